"""The package as others meet it: what it asks for, its version, that all of it imports."""

from functools import cache
import importlib.util
import re
import subprocess
import sys
from xml.etree import ElementTree

import pytest

import create_oi_ros
from source import imported, modules, PACKAGE, ROOT

MODULES = modules(PACKAGE)
FOLDERS = ('launch', 'test', 'bench', 'examples')
"""Beside the package: what only these import may be a test dependency."""
OURS = {PACKAGE, *FOLDERS,
        *(name.split('.')[-1] for folder in FOLDERS for name in modules(folder))}
ROSDEP_KEYS = {name: f'python3-{name}' for name in (
    'hypothesis', 'matplotlib', 'numpy', 'pexpect', 'psutil', 'pytest', 'serial', 'yaml')}
"""Where a module is not called like its rosdep key."""
NO_KEY = {'mcap', 'rosbags'}
"""Modules of which no rosdep key is known: what needs them says how to get them."""
BARE = 'oi', 'sim'  # the odometry, and so the driver, computes with numpy


@cache
def manifest(folder: str) -> ElementTree.Element:
    """Return the parsed package.xml of a folder."""
    return ElementTree.parse(ROOT / folder / 'package.xml').getroot()


def named(*tags: str) -> set[str]:
    """Return what the package's manifest names in elements of these kinds."""
    return {element.text or '' for tag in tags for element in manifest('.').iter(tag)}


def foreign(folder: str) -> set[str]:
    """Return the rosdep keys of all that a folder imports and neither we nor Python bring."""
    tops = {name.split('.')[0] for path in modules(folder).values() for name in imported(path)}
    return {ROSDEP_KEYS.get(top, top) for top in tops - OURS - NO_KEY - sys.stdlib_module_names}


def run_python(*arguments: str) -> None:
    """Run a Python that must succeed and say nothing."""
    done = subprocess.run([sys.executable, *arguments], cwd=ROOT, text=True,
                          capture_output=True, timeout=60)
    assert (done.returncode, done.stdout, done.stderr) == (0, '', '')


@pytest.mark.parametrize('folder', ['.', 'msg_defs', 'tools/tf2_msgs'])
def test_manifest_is_of_format_3(folder: str) -> None:
    assert manifest(folder).get('format') == '3'


def test_manifest_names_all_that_the_package_imports() -> None:
    assert foreign(PACKAGE) | foreign('launch') <= named('depend', 'exec_depend')


def test_manifest_names_all_that_the_tests_import() -> None:
    assert foreign('test') <= named('depend', 'exec_depend', 'test_depend')


def test_one_version() -> None:
    setup = re.findall(r"version='(.*?)'", (ROOT / 'setup.py').read_text())
    changes = re.findall(r'^(\d+\.\d+\.\d+) \(', (ROOT / 'CHANGELOG.rst').read_text(), re.M)
    manifests = [manifest(folder).findtext('version') for folder in ('.', 'msg_defs')]
    assert {*setup, changes[0], *manifests, create_oi_ros.__version__} == {setup[0]}


@pytest.mark.parametrize('module', [  # a __main__ is run, not imported
    module for module in MODULES if not module.endswith('.__main__')])
def test_module_imports_by_itself(module: str) -> None:
    needs_ros = any('rclpy' in name or '_msgs' in name for name in imported(MODULES[module]))
    if needs_ros and not importlib.util.find_spec('rclpy'):
        pytest.skip(f'{module} imports ROS, and there is none here')
    run_python('-c', f'import {module}')


@pytest.mark.parametrize('part', [part for part in BARE if f'{PACKAGE}.{part}' in MODULES])
def test_core_imports_in_a_bare_python(part: str) -> None:
    """Not isolated from the standard library, but from everything installed beside it."""
    run_python('-ISc', f'import sys; sys.path.insert(0, {str(ROOT)!r}); '
                       f'from {PACKAGE} import {part}')
