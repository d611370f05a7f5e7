# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""The command `create_web`: see a robot, and drive it, in a browser."""

from __future__ import annotations

import argparse
import asyncio
from collections.abc import Sequence
from contextlib import suppress
import errno
from importlib.util import find_spec
import os
from pathlib import Path
import re
import secrets
import socket
import ssl
import sys
import time

from rclpy.executors import SingleThreadedExecutor

from ...ros.node_arguments import split
from ...ros.process import call_on_signal, ros_executor, spin_ready
from ...ros.programs import installing, UserError
from ...ros.waiting import say_if_waiting
from .access import is_loopback
from .bag_recording import BagRecording
from .simulated_truth import show_truth
from .viewers import Viewers, WebNode
from .web_server import WebServer

LOOPBACK, PORT = '127.0.0.1', 8080
PORTS = range(PORT, PORT + 20)
"""Ports of which the first free one is taken, without --port."""
TOKEN_BYTES = 16
TOKEN = re.compile(r'[\w-]{20,100}', re.ASCII)
LOOKED_AT, ALONE = 0.05, 0.1
"""Seconds between two looks at what ROS has brought, with a page open and without."""
EVERYWHERE = ('0.0.0.0', '::')
"""Hosts that mean every network of this computer."""
DOCUMENTATION_NET = '192.0.2.1'
"""An address that nobody has: no packet is sent to find the way there."""
CLEAR_LINE = '\r\x1b[K'


def listen(host: str, port: int | None) -> socket.socket:
    """Return a socket that listens; UserError says why it cannot."""
    for each in PORTS if port is None else [port]:
        try:
            family = socket.getaddrinfo(host, each, type=socket.SOCK_STREAM)[0][0]
            return socket.create_server((host, each), family=family)
        except socket.gaierror as error:
            raise UserError(f'--host {host}: {error.strerror}; allowed: an address of this '
                            'computer, or 0.0.0.0 for all of them') from None
        except OSError as error:
            if error.errno != errno.EADDRINUSE:
                raise UserError(f'cannot listen on {host}, port {each}: '
                                f'{error.strerror}') from None
    ports = f'port {port} is' if port else f'the ports {PORTS[0]} to {PORTS[-1]} are'
    raise UserError(f'{ports} in use on {host}: choose another one with --port')


def own_address(host: str) -> str:
    """Return the host to put into the printed address: one that others can reach."""
    if host not in EVERYWHERE:
        return f'[{host}]' if ':' in host else host
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe, suppress(OSError):
        probe.connect((DOCUMENTATION_NET, 9))
        return str(probe.getsockname()[0])
    return socket.gethostname()


def show_qr_code(address: str) -> None:
    """Print the address as a QR code, if segno is installed and this is a terminal."""
    if not sys.stdout.isatty():
        return
    if find_spec('segno') is None:
        print(f'create_web: for a QR code here: {installing("segno")}')
        return
    import segno
    segno.make(address, error='l').terminal(compact=True, border=2)
    sys.stdout.flush()


def kept_token(path: Path) -> str:
    """Return the token in a file, which is made if it is not there; UserError: it is no good."""
    try:
        with open(os.open(path, os.O_RDWR | os.O_CREAT, 0o600), 'r+', encoding='ascii') as file:
            if os.fstat(file.fileno()).st_mode & 0o077:
                raise UserError(f'--token-file {path}: others may read it: chmod 600 {path}')
            token = file.read().strip()
            if not token:
                token = secrets.token_urlsafe(TOKEN_BYTES)
                file.write(f'{token}\n')
    except (OSError, UnicodeDecodeError) as error:
        raise UserError(f'--token-file {path}: {error}') from None
    if not TOKEN.fullmatch(token):
        raise UserError(f'--token-file {path}: no token; allowed: 20 to 100 letters, digits, - '
                        'and _; delete the file, and a new one is made')
    return token


def encryption(cert: Path | None, key: Path | None) -> ssl.SSLContext | None:
    """Return what encrypts the connections; None: nothing. UserError: the files are no good."""
    if cert is None:
        return None
    try:
        made = ssl.create_default_context(ssl.Purpose.CLIENT_AUTH)
        made.load_cert_chain(cert, key)
    except OSError as error:  # an SSLError is one, too
        raise UserError(f'--cert {cert}, --key {key}: {error.strerror or error}; allowed: a '
                        'certificate and its key, as PEM files') from None
    return made


async def _look(node: WebNode, executor: SingleThreadedExecutor, viewers: Viewers,
                recording: BagRecording) -> None:
    """Take what ROS brings, and tell the pages."""
    while True:
        now = time.monotonic()
        node.velocity.find_driver(now)
        node.robot.parts.put('driver_found', node.velocity.driver_listens)
        spin_ready(executor)
        recording.look()
        node.robot.sample(time.monotonic())
        viewers.tell()
        period = LOOKED_AT if len(viewers) else ALONE
        await asyncio.sleep(max(0.0, now + period - time.monotonic()))


async def _serve(executor: SingleThreadedExecutor, listener: socket.socket,
                 options: argparse.Namespace, token: str | None, tls: ssl.SSLContext | None,
                 ended: asyncio.Event) -> None:
    node = WebNode()
    executor.add_node(node)
    recording = BagRecording(node.robot, options.ros)
    viewers = Viewers(node, recording)
    runner = await WebServer(token, viewers, recording, listener, tls).serve()
    port = listener.getsockname()[1]
    _announce(node, f'http{"s" if tls else ""}://{own_address(options.host)}:{port}/', token)
    say_if_waiting(node, 'a driver', lambda: not node.velocity.driver_listens,
                   node.get_logger().warning)
    tasks = [asyncio.create_task(_look(node, executor, viewers, recording)),
             asyncio.create_task(ended.wait())]
    if options.control is not None:
        tasks.append(asyncio.create_task(
            show_truth(options.control, node.robot, node.get_logger().warning)))
    done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
    await viewers.close()
    await runner.cleanup()
    for task in done:
        task.result()  # raises what has ended it


def _announce(node: WebNode, address: str, token: str | None) -> None:
    what = 'in a browser to see and drive the robot'
    if token is None:
        node.get_logger().info(f'open {address} {what}; for phones in your network, too, add '
                               '--host 0.0.0.0')
        return
    # ROS writes its log to files, which must not have the token. A status line may stand here.
    address = f'{address}?token={token}'
    clear = CLEAR_LINE if sys.stdout.isatty() else ''
    print(f'{clear}create_web: open {address} {what}', flush=True)
    show_qr_code(address)


def _port(text: str) -> int:
    if not (text.isdecimal() and 0 < int(text) < 65536):
        raise argparse.ArgumentTypeError(f'{text!r}; allowed: 1 to 65535')
    return int(text)


def _arguments(given: Sequence[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog='create_web', description=__doc__)
    parser.add_argument('--host', default=LOOPBACK, help=(
        'address to serve (default: %(default)s, for this computer only); 0.0.0.0: for all in '
        'your networks who have the printed address'))
    parser.add_argument('--port', type=_port, help=(
        f'TCP port (default: the first free one from {PORTS[0]} to {PORTS[-1]})'))
    parser.add_argument('--control', type=Path, metavar='PATH', help=(
        'control socket of create_sim: show its room, and where the robot really is'))
    parser.add_argument('--token-file', type=Path, metavar='FILE', help=(
        'keep the token in this file, so that it lasts (default: a new one at each start, with '
        '--host)'))
    parser.add_argument('--cert', type=Path, metavar='FILE', help=(
        'encrypt (https) with this certificate, a PEM file, and --key'))
    parser.add_argument('--key', type=Path, metavar='FILE', help='key of the certificate')
    plain, ros = split(given)
    options = parser.parse_args(plain)
    options.ros = ros
    if not options.host:
        parser.error('--host is empty: give an address, or leave it out')
    if (options.cert is None) != (options.key is None):
        parser.error('--cert and --key belong together: give both, or none')
    return options


def main(arguments: Sequence[str] | None = None) -> int:
    """Serve until a signal."""
    given = sys.argv[1:] if arguments is None else list(arguments)
    options = _arguments(given)
    tls = encryption(options.cert, options.key)
    token = None if is_loopback(options.host) else secrets.token_urlsafe(TOKEN_BYTES)
    if options.token_file is not None:
        token = kept_token(options.token_file)
    with asyncio.Runner() as runner, listen(options.host, options.port) as listener:
        ended, loop = asyncio.Event(), runner.get_loop()
        call_on_signal(lambda: loop.call_soon_threadsafe(ended.set))
        with ros_executor(given) as executor:
            runner.run(_serve(executor, listener, options, token, tls, ended))
    return 0
