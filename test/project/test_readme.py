"""The README agrees with the code."""

import pytest

from create_oi_ros.ros.reference import POLICY, rewritten, TABLES
from support.source import ROOT

README = (ROOT / 'README.md').read_text()


@pytest.mark.parametrize(('name', 'labels'), [
    ('README.md', TABLES), ('config/sros2_policy.xml', POLICY)])
def test_generated_blocks_are_made_from_the_code(name, labels):
    text = (ROOT / name).read_text('utf-8')
    assert all(f'<!-- {label} -->' in text for label in labels)
    assert rewritten(text) == text, 'run `make docs`'


def test_the_script_in_the_readme_is_the_example():
    for name in ('drive.py', 'square.py'):
        assert f'```python\n{(ROOT / "examples" / name).read_text()}```' in README
