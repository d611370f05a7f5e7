# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""What `create_web` does with bad HTTP, files of tokens and certificates, and arguments."""

from contextlib import closing
import http.client
import signal
import socket
import ssl
import subprocess

import pytest

from create_oi_ros.apps.web.create_web import encryption, kept_token, listen, main
from create_oi_ros.ros.programs import UserError
from support.ros import TIMEOUT
from support.web import free_port, get, port_of, refusal, served


@pytest.fixture(scope='module')
def server(shared_stage):
    """Return a server with a token, and the address that it prints."""
    folder = shared_stage.folder
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv('ROS_LOG_DIR', str(folder / 'log'))
        return served(shared_stage, '--host', '0.0.0.0', '--token-file', str(folder / 'token'),
                      '--control', str(folder / 'nowhere'))


def local(address: str) -> str:
    """Return the address of a server for this computer."""
    return f'http://127.0.0.1:{port_of(address)}/'


def test_bad_http_is_refused_without_a_traceback_and_others_are_served(server):
    web, address = server
    with closing(socket.create_connection(('127.0.0.1', port_of(address)))) as connection:
        connection.settimeout(TIMEOUT)
        connection.sendall(b'GET / HTTP/9.9.9\r\nHost: x\r\n\r\n')
        assert b' 400 ' in connection.recv(4096)
    assert get(local(address), '/')[0] == 401
    assert 'Traceback' not in web.output


def test_from_other_computers_a_token_is_needed(server, pages):
    web, address = server
    base, _, token = address.partition('?token=')
    assert len(token) >= 20
    assert not base.startswith('http://0.0.0.0')
    here = local(address)
    status, _, body = get(here, '/')
    assert status == 401 and 'Which token?' in body
    for path in ('/?token=', '/?token=%ff', f'/?token={token}x'):
        assert get(here, path)[1]['Location'] == '/#wrong', path
    assert get(here, '/main.js')[0] == 401
    assert get(here, '/style.css')[0] == 200, 'the question is styled, too'
    assert refusal(pages, here) == 401
    assert refusal(pages, here, token='wrong') == 401
    status, headers, _ = get(here, f'/?token={token}')
    assert (status, headers['Location']) == (303, '/')
    cookie = headers['Set-Cookie']
    assert 'HttpOnly' in cookie and 'SameSite=Lax' in cookie
    assert get(here, '/', Cookie=cookie.partition(';')[0])[0] == 200
    assert get(here, '/', Cookie=b'create_web=\xff'.decode('latin-1'))[0] == 401
    assert refusal(pages, here, token=token, origin='http://evil.example') == 403
    page = pages(here, token=token)
    page.until(lambda: page.known['seat']['viewers'] == 1)
    assert 'Traceback' not in web.output and 'Error' not in web.output


def test_a_control_socket_that_is_not_there_is_said(shared_stage, server):
    web, _ = server
    shared_stage.ros.until(
        lambda: 'nowhere: no simulated robot answers there (No such file' in web.output)


def test_a_token_in_a_file_lasts_and_no_log_has_it(shared_stage, server):
    web, address = server
    token = address.partition('?token=')[2]
    folder = shared_stage.folder
    file = folder / 'token'
    assert file.read_text() == f'{token}\n' and file.stat().st_mode & 0o777 == 0o600
    web.send(signal.SIGTERM)
    assert web.ended() == 0
    logs = [path.read_text() for path in (folder / 'log').rglob('*') if path.is_file()]
    assert not any(token in log for log in logs)
    again, _ = served(shared_stage, '--host', '0.0.0.0', '--token-file', str(file),
                      '--port', str(port_of(address)))
    cookie = f'create_web_{port_of(address)}={token}'
    assert get(local(address), '/', Cookie=cookie)[0] == 200
    again.send(signal.SIGTERM)


@pytest.mark.parametrize(('text', 'mode', 'words'), [
    ('', 0o644, 'others may read it'), ('secret', 0o600, '20 to 100 letters'),
    ('with spaces, and more than twenty', 0o600, 'allowed'), ('é' * 30, 0o600, "can't decode")])
def test_a_file_that_is_no_good_for_a_token_is_refused(tmp_path, text, mode, words):
    file = tmp_path / 'token'
    file.write_text(text)
    file.chmod(mode)
    with pytest.raises(UserError, match=words):
        kept_token(file)
    assert file.read_text() == text
    with pytest.raises(UserError, match='Is a directory'):
        kept_token(tmp_path)


def test_with_a_certificate_the_page_is_encrypted(shared_stage):
    cert, key = shared_stage.folder / 'cert.pem', shared_stage.folder / 'key.pem'
    subprocess.run(['openssl', 'req', '-x509', '-newkey', 'ed25519', '-nodes', '-days', '2',
                    '-subj', '/CN=localhost', '-addext', 'subjectAltName=IP:127.0.0.1',
                    '-keyout', key, '-out', cert], check=True, capture_output=True)
    port = free_port()
    web, address = served(shared_stage, '--host', '0.0.0.0', '--port', str(port),
                          '--cert', str(cert), '--key', str(key))
    assert address.startswith('https://')
    trusting = ssl.create_default_context(cafile=cert)
    token = address.partition('?token=')[2]
    with closing(http.client.HTTPSConnection(
            '127.0.0.1', port, timeout=20, context=trusting)) as asked:
        asked.request('GET', f'/?token={token}')
        cookie = asked.getresponse().headers['Set-Cookie']
    assert 'Secure' in cookie and 'HttpOnly' in cookie
    assert 'Traceback' not in web.output


def test_a_certificate_that_is_none_is_refused(tmp_path):
    (tmp_path / 'cert').write_text('none')
    with pytest.raises(UserError, match='a certificate and its key, as PEM files'):
        encryption(tmp_path / 'cert', tmp_path / 'cert')
    with pytest.raises(UserError, match='No such file'):
        encryption(tmp_path / 'nothing', tmp_path / 'cert')
    assert encryption(None, None) is None


# The command line.


@pytest.mark.parametrize(('arguments', 'words'), [
    (['--port', '0'], "'0'; allowed: 1 to 65535"), (['--port', 'http'], 'allowed: 1 to 65535'),
    (['--host', ''], '--host is empty'), (['--nonsense'], 'unrecognized arguments')])
def test_arguments_that_make_no_sense_are_refused(capsys, arguments, words):
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    assert ended.value.code == 2
    assert words in capsys.readouterr().err


def test_a_port_or_address_that_cannot_be_served_is_said():
    with socket.create_server(('127.0.0.1', 0)) as taken:
        port = taken.getsockname()[1]
        for arguments, words in (
                (('--port', str(port)), f'port {port} is in use on 127.0.0.1'),
                (('--host', '192.0.2.1'), 'cannot listen on 192.0.2.1'),
                (('--host', 'no such host'), '--host no such host:')):
            with pytest.raises(UserError, match=words):
                main(arguments)


def test_without_a_port_the_next_free_one_is_taken():
    with listen('127.0.0.1', None) as first, listen('127.0.0.1', None) as second:
        assert first.getsockname()[1] < second.getsockname()[1]
