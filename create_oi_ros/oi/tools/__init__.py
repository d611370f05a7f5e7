"""Tools that show the Open Interface to people: text form, transcripts, tables, captures."""
