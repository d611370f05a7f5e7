# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""Files that are written as a whole or not at all."""

from pathlib import Path
import resource

import pytest

from create_oi_ros.ros.whole_file import write_whole


def test_a_file_is_replaced_and_keeps_its_permissions(tmp_path: Path) -> None:
    target = tmp_path / 'model.yaml'
    target.write_text('old')
    target.chmod(0o640)
    write_whole(target, b'new')
    assert target.read_text() == 'new'
    assert target.stat().st_mode & 0o777 == 0o640
    assert list(tmp_path.iterdir()) == [target], 'nothing is left beside it'


def test_a_link_stays_and_its_target_is_replaced(tmp_path: Path) -> None:
    target, link = tmp_path / 'model.yaml', tmp_path / 'link'
    target.write_text('old')
    link.symlink_to(target)
    write_whole(link, b'new')
    assert link.is_symlink()
    assert target.read_text() == 'new'


def test_a_file_that_does_not_fit_leaves_the_old_one(tmp_path: Path) -> None:
    target = tmp_path / 'model.yaml'
    target.write_text('old')
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (16, limits[1]))  # no file may be larger
    try:
        with pytest.raises(OSError, match='too large'):
            write_whole(target, bytes(17))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert target.read_text() == 'old'
    assert list(tmp_path.iterdir()) == [target], 'nothing is left beside it'


@pytest.mark.parametrize('name', ['no/such/folder', '.'])
def test_what_cannot_be_written_is_an_error_that_names_it(tmp_path: Path, name: str) -> None:
    target = tmp_path / name
    with pytest.raises(OSError, match=str(target)) as error:
        write_whole(target, b'new')
    assert error.value.filename == str(target)
    assert list(tmp_path.iterdir()) == []
