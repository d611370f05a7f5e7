"""The README matches the code."""

from pathlib import Path

from create_oi_ros.ros.reference import rewritten, TABLES

ROOT = Path(__file__).parents[2]
README = (ROOT / 'README.md').read_text()


def test_the_tables_are_made_from_the_code():
    assert all(f'<!-- {name} -->' in README for name in TABLES)
    assert rewritten(README) == README, 'run `make docs`'


def test_the_script_in_the_readme_is_the_example():
    assert f'```python\n{(ROOT / "examples" / "drive.py").read_text()}```' in README
