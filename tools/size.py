# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Print how large the project is: tracked lines, files and words, beside what they should be."""

from pathlib import Path
import subprocess

ROOT = Path(__file__).parents[1]
GOALS = {
    'create_oi_ros': (21_600, 165), 'create_oi_ros/odometry': (900, 7),
    'create_oi_ros/oi': (3000, None), 'create_oi_ros/link': (800, None),
    'create_oi_ros/driver': (3800, 22), 'create_oi_ros/ros': (3300, 24),
    'create_oi_ros/apps': (4200, 38), 'create_oi_ros/sim': (5000, 38), 'test': (20_000, None),
    'bench': (2400, None)}
"""Lines and files of Python at most."""
JSON_LINES, WORDS = 400, 22_000


def tracked(folder: str, ending: str) -> list[str]:
    """Return the texts of the tracked files of a folder."""
    names = subprocess.run(['git', 'ls-files', '-z', '--', f'{folder}/*{ending}'], cwd=ROOT,
                           text=True, capture_output=True, check=True).stdout.split('\0')
    paths = [ROOT / name for name in names if name and not name.endswith('docs/interface.md')]
    return [path.read_text('utf-8') for path in paths if path.is_file()]


def lines_of(texts: list[str]) -> int:
    """Return how many lines texts have, blank ones and comments included."""
    return sum(text.count('\n') for text in texts)


def rows() -> list[tuple[str, str, str]]:
    """Return what is counted, how much there is, and how much there should be at most."""
    found = []
    for folder, (lines, files) in GOALS.items():
        texts = tracked(folder, '.py')
        found.append((f'{folder}: lines, files',
                      f'{lines_of(texts):,} in {len(texts)}',
                      f'{lines:,}' + (f' in {files}' if files else '')))
    lines = lines_of(tracked('bench', '.json'))
    words = sum(len(text.split()) for text in [
        (ROOT / 'README.md').read_text('utf-8'), *tracked('docs', '.md')])
    return [*found, ('bench: lines of JSON', f'{lines:,}', f'{JSON_LINES:,}'),
            ('README and docs: words, interface.md apart', f'{words:,}', f'{WORDS:,}')]


for name, there, goal in rows():
    print(f'{name:<45}{there:>15}   at most {goal}')
