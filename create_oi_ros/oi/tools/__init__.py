"""What explains the Open Interface to people: text form, transcripts, tables, captures."""
