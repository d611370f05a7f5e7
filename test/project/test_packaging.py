# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The package: its dependencies and its version; its set-up and build; its workflow on GitHub."""

from functools import cache
from importlib.metadata import version
import importlib.util
import os
from pathlib import Path
import re
import shlex
import shutil
import subprocess
import sys
from xml.etree import ElementTree

import pytest
import yaml

import create_oi_ros
from create_oi_ros.ros.programs import FOR_BAGS, installing
from support.source import imported, modules, PACKAGE, ROOT

FOLDERS = ('launch', 'test', 'bench', 'tools', 'examples')
"""Folders beside the package; what only they import may be a test dependency."""
OURS = {PACKAGE, *FOLDERS,
        *(name.split('.')[-1] for folder in FOLDERS for name in modules(folder))}
ROSDEP_KEYS = {name: f'python3-{name}' for name in (
    'aiohttp', 'hypothesis', 'matplotlib', 'numpy', 'pytest', 'segno', 'serial', 'yaml')}
"""Modules whose rosdep key has another name."""
NO_KEY = {'mcap': 'docs/recording.md', 'rosbags': 'docs/recording.md',
          'playwright': 'CONTRIBUTING.md'}
"""Optional modules that no Debian package has, and the page that says how to install them."""
BROUGHT = {'coverage', 'zstandard'}
"""Modules that come with others: `pytest-cov` and `mcap` need them."""
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
    return {ROSDEP_KEYS.get(top, top) for top in tops - OURS - {*NO_KEY} - BROUGHT
            - sys.stdlib_module_names}


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
    versions = installing(*FOR_BAGS).strip('`').partition(" 'mcap")[2]
    assert versions in (ROOT / NO_KEY['mcap']).read_text('utf-8')


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


# rosdep, the real one, without a network: its sources and ROS's index are files of the test.


JAZZY = ('action_msgs ament_cmake ament_index_python builtin_interfaces diagnostic_msgs '
         'domain_coordinator geometry_msgs launch launch_ros nav_msgs rcl_interfaces rclpy '
         'robot_state_publisher ros2launch rosgraph_msgs rosidl_default_generators '
         'rosidl_default_runtime sensor_msgs std_msgs std_srvs tf2_msgs').split()
"""Packages of ROS 2 Jazzy."""
UBUNTU = [f'python3-{name}' for name in (
    'aiohttp', 'hypothesis', 'matplotlib', 'numpy', 'pytest', 'pytest-cov', 'pytest-timeout',
    'pytest-xdist', 'segno', 'serial', 'yaml')]
"""Keys of rosdep that are packages of Ubuntu, of the same name."""
ROSDEP_INSTALL = sorted({
    command.strip() for name in (
        'README.md', 'Dockerfile', 'docs/raspberry_pi.md', '.github/workflows/ci.yml')
    for command in re.findall(r'rosdep install [^\n\\]*', (ROOT / name).read_text('utf-8'))})


@pytest.fixture
def rosdep(tmp_path, monkeypatch):
    """Return a function that runs rosdep in a workspace, on a computer without these packages."""
    program = shutil.which('rosdep')
    if program is None:
        pytest.skip('no rosdep here')

    def write(name: str, content: object) -> str:
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(f'%YAML 1.1\n---\n{yaml.safe_dump(content)}')
        return f'file://{path}'
    keys = write('keys.yaml', {key: {'ubuntu': [key]} for key in UBUNTU})
    (tmp_path / 'sources').mkdir()
    (tmp_path / 'sources' / 'keys.list').write_text(f'yaml {keys}\n')
    write('jazzy.yaml', {
        'type': 'distribution', 'version': 2, 'release_platforms': {'ubuntu': ['noble']},
        'repositories': {'all': {'release': {
            'packages': JAZZY, 'version': '1.0.0-1', 'url': 'https://example.com/all.git',
            'tags': {'release': '{package}/{version}'}}}}})
    index = write('index.yaml', {'type': 'index', 'version': 4, 'distributions': {'jazzy': {
        'distribution': ['jazzy.yaml'], 'distribution_cache': '', 'python_version': 3,
        'distribution_status': 'active', 'distribution_type': 'ros2'}}})
    for name, value in (('ROSDEP_SOURCE_PATH', tmp_path / 'sources'), ('ROS_DISTRO', 'jazzy'),
                        ('ROSDISTRO_INDEX_URL', index), ('ROS_HOME', tmp_path / 'home')):
        monkeypatch.setenv(name, str(value))
    monkeypatch.delenv('AMENT_PREFIX_PATH', raising=False)
    (tmp_path / 'src').mkdir()
    (tmp_path / 'src' / PACKAGE).symlink_to(ROOT)

    def run(command: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run([program, *shlex.split(command)[1:]], cwd=tmp_path, text=True,
                              capture_output=True, timeout=60)
    assert run('rosdep update').returncode == 0
    return run


def test_rosdep_finds_all_that_the_packages_need(rosdep):
    for command in ROSDEP_INSTALL:
        done = rosdep(f'{command} --simulate --os=ubuntu:noble')
        assert (done.returncode, done.stderr) == (0, ''), command
        assert 'ros-jazzy-rosidl-default-generators' in done.stdout, 'the messages need it'
        assert 'ros-jazzy-create' not in done.stdout
    assert 'create_oi_msgs' in rosdep(
        f'{command} --simulate --os=ubuntu:noble'.replace(' --ignore-src', '')).stderr


# Set-up and build: what they say, and where they put what they make.


TOOLS = ROOT / 'tools'


@pytest.fixture
def tool(monkeypatch):
    """Return a function that imports a file of tools/."""
    def load(name):
        monkeypatch.syspath_prepend(TOOLS)
        monkeypatch.delitem(sys.modules, 'step', raising=False)
        spec = importlib.util.spec_from_file_location(name, TOOLS / f'{name}.py')
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        return module
    return load


@pytest.mark.parametrize('why', ['one was removed', 'the build was cut short'])
def test_messages_are_built_anew_when(tool, tmp_path, monkeypatch, why):
    monkeypatch.chdir(tmp_path)
    built = tmp_path / 'install/create_oi_msgs/share/create_oi_msgs'
    for folder in (tmp_path / 'msg_defs', built):
        for name in ('msg/Song.msg', 'srv/Stop.srv', 'action/Dock.action'):
            (folder / name).parent.mkdir(parents=True)
            (folder / name).touch()
    (tmp_path / 'build/create_oi_msgs').mkdir(parents=True)
    build = tool('build')
    build.forget_stale()
    assert built.exists()
    if why == 'one was removed':
        (tmp_path / 'msg_defs/srv/Stop.srv').unlink()
    else:
        with pytest.raises(SystemExit), monkeypatch.context() as patched:
            patched.setattr(build, 'step', lambda *_, **__: sys.exit('interrupted'))
            build.main('wheels')
    build.forget_stale()
    assert not built.exists()
    assert not (tmp_path / 'build/create_oi_msgs').exists()


@pytest.mark.parametrize('name', ['a b', 'ümlaut', 'a;b', '$HOME'])
def test_what_is_made_for_a_special_path_is_elsewhere(tool, tmp_path, monkeypatch, name):
    clone, cache = tmp_path / name, tmp_path / 'cache'
    clone.mkdir()
    monkeypatch.chdir(clone)
    monkeypatch.setenv('XDG_CACHE_HOME', str(cache))
    folders = tool('folders')
    folders.make_anew()
    (clone / 'build' / 'old').touch()
    folders.make_anew()
    for each in ('.venv', 'build', 'install'):
        real = (clone / each).resolve()
        assert real.is_dir() and not list(real.iterdir())
        assert folders.is_plain(real) and cache in real.parents
    done = subprocess.run(['make', '-f', ROOT / 'Makefile', 'clean'], cwd=clone, check=False)
    assert done.returncode == 0
    assert not list(clone.iterdir()) and not list(cache.iterdir())


@pytest.mark.parametrize('name, sentence', [
    ('a b', 'set XDG_CACHE_HOME to a folder whose path has none'),
    ("it's", 'make cannot work in a path with a quote')])
def test_a_path_in_which_nothing_can_be_built_is_refused_in_one_line(tmp_path, name, sentence):
    folder = tmp_path / name
    folder.mkdir()
    done = subprocess.run(
        [sys.executable, TOOLS / 'check.py', 'jazzy'], cwd=folder, text=True, check=False,
        capture_output=True, env={**os.environ, 'XDG_CACHE_HOME': str(folder)})
    assert (done.returncode, done.stderr, done.stdout.count('\n')) == (1, '', 1)
    assert sentence in done.stdout and str(folder) in done.stdout.replace('\\', '')
