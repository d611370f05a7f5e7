# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The package: its dependencies, its version, and that every module imports by itself."""

from functools import cache
from importlib.metadata import version
from pathlib import Path
import re
import shutil
import subprocess
import sys
from xml.etree import ElementTree

import pytest

import create_oi_ros
from support.source import imported, modules, PACKAGE, ROOT

FOLDERS = ('launch', 'test', 'bench', 'examples')
"""Folders beside the package; what only they import may be a test dependency."""
OURS = {PACKAGE, *FOLDERS,
        *(name.split('.')[-1] for folder in FOLDERS for name in modules(folder))}
ROSDEP_KEYS = {name: f'python3-{name}' for name in (
    'aiohttp', 'hypothesis', 'matplotlib', 'numpy', 'pytest', 'segno', 'serial', 'yaml')} | {
        'PIL': 'python3-pil'}
"""Modules whose rosdep key has another name."""
NO_KEY = {'mcap': 'CONTRIBUTING.md', 'rosbags': 'docs/recording.md',
          'playwright': 'CONTRIBUTING.md'}
"""Optional modules that no Debian package has, and the page that says how to install them."""
NOT_IMPORTED = {
    'launch': 'launch files; our folder has that name', 'ros2launch': '`ros2 launch`',
    'robot_state_publisher': 'started by a launch file',
    **dict.fromkeys(('python3-pytest-cov', 'python3-pytest-timeout', 'python3-pytest-xdist'),
                    'plugins of pytest')}
"""Dependencies that no file imports, and what they are for."""
MAKES_WHEELS = 71
"""The first major version of setuptools that needs no other package for that."""
SOURCES = {'.py', '.sh', '.yml', '.msg', '.srv', '.action', '.js', '.css', '.html', '.urdf'}
NAMES = {'CMakeLists.txt', 'Makefile', 'Dockerfile', 'run'}
LICENCE = 'Apache-2.0'


@cache
def manifest(folder: str) -> ElementTree.Element:
    """Return the parsed package.xml of a folder."""
    return ElementTree.parse(ROOT / folder / 'package.xml').getroot()


def named(*tags: str) -> set[str]:
    """Return the contents of all elements with these tags in the package's manifest."""
    return {element.text or '' for tag in tags for element in manifest('.').iter(tag)}


def foreign(folder: str) -> set[str]:
    """Return the rosdep keys of other people's packages that a folder imports."""
    tops = {name.split('.')[0] for path in modules(folder).values() for name in imported(path)}
    return {ROSDEP_KEYS.get(top, top) for top in tops - OURS - {*NO_KEY} - sys.stdlib_module_names}


def run_python(*arguments: str, timeout: float = 60) -> None:
    """Run Python; it must succeed and print nothing."""
    done = subprocess.run([sys.executable, *arguments], cwd=ROOT, text=True,
                          capture_output=True, timeout=timeout)
    assert (done.returncode, done.stdout, done.stderr) == (0, '', '')


def test_the_manifest_names_all_that_is_imported_and_nothing_else() -> None:
    assert foreign(PACKAGE) | foreign('launch') <= named('depend', 'exec_depend')
    needed = set().union(*map(foreign, (PACKAGE, *FOLDERS)))
    given = named('depend', 'exec_depend', 'test_depend')
    assert needed <= given <= needed | {*NOT_IMPORTED}
    for module, page in NO_KEY.items():
        assert re.search(rf'pip install .*\b{module}\b', (ROOT / page).read_text('utf-8'))


def test_the_version_and_the_licence_are_everywhere_the_same() -> None:
    setup, = re.findall(r"version='(.*?)'", (ROOT / 'setup.py').read_text())
    for folder in ('.', 'msg_defs'):
        assert manifest(folder).findtext('version') == setup == create_oi_ros.__version__
        assert manifest(folder).findtext('license') == LICENCE
        # The form is that of REP 132, which ROS's release tools read.
        newest, *older = re.findall(r'^(\S.*)\n-+$', (ROOT / folder / 'CHANGELOG.rst').read_text(),
                                    re.M)
        assert newest == 'Forthcoming' or newest.startswith(f'{setup} (')
        assert all(re.fullmatch(r'\d+\.\d+\.\d+ \(\d{4}-\d\d-\d\d\)', each) for each in older)


def test_every_source_file_says_its_licence() -> None:
    tracked = subprocess.run(['git', 'ls-files'], cwd=ROOT, text=True, capture_output=True)
    if tracked.returncode:
        pytest.skip('not a clone of git: an archive has no list of its files')
    files = [ROOT / name for name in tracked.stdout.splitlines()]
    heads = {path: path.read_text('utf-8')[:600] for path in files
             if path.is_file() and (path.suffix in SOURCES or path.name in NAMES)}
    assert len(heads) > 100
    assert not {path for path, head in heads.items()
                if f'SPDX-License-Identifier: {LICENCE}' not in head or 'Copyright' not in head}


def test_every_module_can_be_imported() -> None:
    """In any order, since no imports form a ring (see test_layers)."""
    run_python('-W', 'ignore:This process:DeprecationWarning', '-c',
               f'import {", ".join(modules(PACKAGE))}')


def test_the_core_is_installed_without_ros(tmp_path: Path) -> None:
    """`pip install` of the repository works where no ROS is, and brings the protocol."""
    pytest.importorskip('pip', reason='no pip here')
    if int(version('setuptools').partition('.')[0]) < MAKES_WHEELS:
        pytest.importorskip('wheel', reason='no wheel here, which this setuptools needs')
    clone = tmp_path / 'clone'
    made = shutil.ignore_patterns('__pycache__')
    shutil.copytree(ROOT / PACKAGE, clone / PACKAGE, ignore=made)
    for name in ('resource', 'launch', 'config', 'urdf', 'rviz'):
        shutil.copytree(ROOT / name, clone / name, ignore=made)
    for name in ('setup.py', 'setup.cfg', 'pyproject.toml', 'package.xml', 'README.md', 'LICENSE'):
        shutil.copy(ROOT / name, clone)
    built = subprocess.run(
        [sys.executable, '-m', 'pip', 'wheel', '--quiet', '--no-deps', '--no-index',
         '--no-build-isolation', '--disable-pip-version-check', '--wheel-dir', tmp_path, clone],
        text=True, capture_output=True, timeout=120)
    assert built.returncode == 0, built.stderr
    wheel, = tmp_path.glob(f'{PACKAGE}-{create_oi_ros.__version__}-*.whl')
    run_python('-ISc', (
        f'import sys; sys.path.insert(0, {str(wheel)!r}); from create_oi_ros import oi, sim; '
        f'assert oi.__file__.startswith({str(wheel)!r}); '
        'assert bytes(oi.Start()) == b"\\x80"; import create_oi_ros.oi.tools.text; '
        'from create_oi_ros.sim.world import shipped; shipped("room")'))
