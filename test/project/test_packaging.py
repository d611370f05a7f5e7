# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The package: its dependencies, its version, and that every module imports by itself."""

from functools import cache
from importlib.metadata import version
import importlib.util
from pathlib import Path
import re
import shutil
import subprocess
import sys
from xml.etree import ElementTree

import pytest

import create_oi_ros
from support.source import imported, modules, PACKAGE, ROOT

MODULES = modules(PACKAGE)
FOLDERS = ('launch', 'test', 'bench', 'examples')
"""Folders beside the package; what only they import may be a test dependency."""
OURS = {PACKAGE, *FOLDERS,
        *(name.split('.')[-1] for folder in FOLDERS for name in modules(folder))}
ROSDEP_KEYS = {name: f'python3-{name}' for name in (
    'aiohttp', 'hypothesis', 'matplotlib', 'numpy', 'pytest', 'segno', 'serial', 'yaml')} | {
        'PIL': 'python3-pil'}
"""Modules whose rosdep key has another name."""
NO_KEY = {'mcap': 'docs/recording.md', 'rosbags': 'docs/recording.md',
          'playwright': 'CONTRIBUTING.md'}
"""Optional modules that no Debian package has, and the page that says how to install them."""
NOT_IMPORTED = {
    'launch': 'launch files; our folder has that name', 'ros2launch': '`ros2 launch`',
    'robot_state_publisher': 'started by a launch file',
    **dict.fromkeys(('python3-pytest-cov', 'python3-pytest-timeout', 'python3-pytest-xdist'),
                    'plugins of pytest')}
"""Dependencies that no file imports, and what they are for."""
IMPORT_EACH = """
import importlib, os, sys, traceback
os.environ['OPENBLAS_NUM_THREADS'] = '1'  # numpy's threads would not be in a fork
for name in sys.argv[1].split():
    try:  # a name in a module is no module
        importlib.import_module(name)
    except ImportError:
        pass
failed = 0
for module in sys.argv[2].split():
    child = os.fork()
    if not child:
        try:
            importlib.import_module(module)
            sys.stdout.flush()
            os._exit(0)
        except BaseException:
            traceback.print_exc()
            os._exit(1)
    failed |= os.waitpid(child, 0)[1]
sys.exit(failed != 0)
"""
"""Imports the modules of its first argument, then each of its second in a fork of its own."""
MAKES_WHEELS = 71
"""The first major version of setuptools that needs no other package for that."""
BARE = 'oi', 'sim'  # the odometry, and so the driver, computes with numpy


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


@pytest.mark.parametrize('folder', ['.', 'msg_defs', 'tools/tf2_msgs'])
def test_manifest_is_of_format_3(folder: str) -> None:
    assert manifest(folder).get('format') == '3'


def test_manifest_names_all_that_the_package_imports() -> None:
    assert foreign(PACKAGE) | foreign('launch') <= named('depend', 'exec_depend')


def test_manifest_names_all_that_the_tests_import() -> None:
    assert foreign('test') <= named('depend', 'exec_depend', 'test_depend')


@pytest.mark.parametrize('folder', ['examples', 'bench'])
def test_manifest_names_all_that_examples_and_benches_import(folder: str) -> None:
    assert foreign(folder) <= named('depend', 'exec_depend', 'test_depend')


def test_manifest_names_nothing_that_is_not_needed() -> None:
    imported_keys = set().union(*map(foreign, (PACKAGE, *FOLDERS)))
    assert named('depend', 'exec_depend', 'test_depend') - imported_keys <= {*NOT_IMPORTED}


@pytest.mark.parametrize('module', NO_KEY)
def test_a_page_says_how_to_install_what_has_no_key(module: str) -> None:
    page = (ROOT / NO_KEY[module]).read_text('utf-8')
    assert re.search(rf'pip install .*\b{module}\b', page)


def test_one_version() -> None:
    setup = re.findall(r"version='(.*?)'", (ROOT / 'setup.py').read_text())
    manifests = [manifest(folder).findtext('version') for folder in ('.', 'msg_defs')]
    assert {*setup, *manifests, create_oi_ros.__version__} == {setup[0]}


@pytest.mark.parametrize('folder', ['.', 'msg_defs'])
def test_changelog_begins_with_this_version_or_the_next(folder: str) -> None:
    """The form is that of REP 132, which ROS's release tools read."""
    text = (ROOT / folder / 'CHANGELOG.rst').read_text()
    sections = re.findall(r'^(\S.*)\n-+$', text, re.M)
    released = re.compile(r'(\d+\.\d+\.\d+) \(\d{4}-\d\d-\d\d\)')
    assert all(map(released.fullmatch, sections[1:]))
    newest = released.fullmatch(sections[0])
    assert newest[1] == create_oi_ros.__version__ if newest else sections[0] == 'Forthcoming'


@pytest.mark.filterwarnings('ignore::DeprecationWarning:catkin_pkg')
@pytest.mark.parametrize('folder', ['.', 'msg_defs'])
def test_the_tools_of_ros_read_the_changelog(folder: str) -> None:
    changelog = pytest.importorskip('catkin_pkg.changelog', reason='no catkin_pkg here')
    pytest.importorskip('docutils', reason='no docutils here')
    # As catkin_prepare_release does: it takes nothing for a version that has no date.
    text = (ROOT / folder / 'CHANGELOG.rst').read_text().replace(
        'Forthcoming\n-----------\n',
        f'{create_oi_ros.__version__} (2026-01-01)\n------------------\n')
    read = changelog.populate_changelog_from_rst(changelog.Changelog(), text)
    newest, _, changes = next(iter(read.foreach_version()))
    assert newest == create_oi_ros.__version__ and changes


def test_the_quality_declaration_gives_a_reason_for_each_dependency() -> None:
    page = (ROOT / 'QUALITY_DECLARATION.md').read_text('utf-8')
    reasons = dict(re.findall(r'^\| ([\w, ]+) \| (.+) \|$', page, re.M))
    given = {name.lower() for names in reasons for name in names.split(', ')}
    called = {'serial': 'pyserial', 'yaml': 'pyyaml'}
    needed = {key.removeprefix('python3-') for key in named('depend', 'exec_depend')
              if key.startswith('python3-')}
    assert {called.get(name, name) for name in needed} <= given
    assert all(name in page for name in named('depend', 'exec_depend')
               if 'launch' in name or name in ('rclpy', 'robot_state_publisher'))


def test_each_module_imports_by_itself() -> None:
    """In a process that has imported others' packages only: a process each takes minutes."""
    ros = importlib.util.find_spec('rclpy') is not None
    ours = [module for module, path in MODULES.items() if not module.endswith('.__main__') and (
        ros or not any('rclpy' in name or '_msgs' in name for name in imported(path)))]
    others = {name for path in MODULES.values() for name in imported(path)
              if not name.startswith(PACKAGE)}
    run_python('-W', 'ignore:This process:DeprecationWarning', '-c', IMPORT_EACH,
               ' '.join(sorted(others)), ' '.join(ours), timeout=220)
    assert len(ours) > 200 or not ros


def test_a_module_that_does_not_import_by_itself_is_named() -> None:
    done = subprocess.run([sys.executable, '-c', IMPORT_EACH, 'os', 'json json.none'], text=True,
                          capture_output=True, timeout=60)
    assert done.returncode == 1 and "No module named 'json.none'" in done.stderr


@pytest.mark.parametrize('part', [part for part in BARE if f'{PACKAGE}.{part}' in MODULES])
def test_core_imports_in_a_bare_python(part: str) -> None:
    """With the standard library, but without installed packages."""
    run_python('-ISc', f'import sys; sys.path.insert(0, {str(ROOT)!r}); '
                       f'from {PACKAGE} import {part}')


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
