# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""All faults of the nightly."""

import signal

from geometry_msgs.msg import Twist, Vector3

from nightly.driver_faults import (
    commands_end,
    ended,
    killed,
    publishing,
    raising,
    suspended,
    told_to_stop,
)
from nightly.fault import Fault
from nightly.link_faults import (
    at_other_rate,
    command_cut_short,
    damaging_commands,
    disturbing,
    FOLLOW_TIMEOUT,
    losing,
    plug,
    plug_elsewhere,
    restarted,
    sending,
    told_other_rate,
    told_to_wait,
    unplug,
)

BOOT = 3.0
"""Seconds that the boot loader of a robot takes."""
FAULTS = (
    Fault('cable out and in', losing(unplug, plug)),
    Fault('port renamed', losing(unplug, plug_elsewhere)),
    Fault('cable broken and mended', losing(sending('cable cut'), sending('cable mend'))),
    Fault('robot off and on', losing(sending('power off'), sending('power on'))),
    Fault('robot off and on, 3 s of boot loader', losing(
        sending('power off'), sending('power on', f'after {BOOT}')), robot=('--seed', '1')),
    Fault('battery out and in', losing(
        sending('power fail'), sending('after 1.0', f'after {BOOT - 1}')),
        robot=('--seed', '2')),
    Fault('simulator restarted', restarted),
    Fault('silence', losing(sending('fault silence@0+999999'), sending('fault off'))),
    Fault('robot deaf for a while', disturbing('deaf@0+999999')),
    Fault('bad line: 5 % flipped, short, garbage', disturbing('flip:0.05 drop:0.05 garbage:0.05')),
    Fault('all bytes garbled', disturbing('flip:1 drop:1 garbage:1')),
    Fault('bytes to the robot damaged, 10 %', damaging_commands(
        'flip.in:0.1', 'drop.in:0.1', 'garbage.in:0.1'), recovery=FOLLOW_TIMEOUT,
        zero=FOLLOW_TIMEOUT, node={'baud': 0}),
    Fault('robot told to wait for ever', told_to_wait, node={'baud': 0}),
    Fault('robot told another baud rate', told_other_rate, node={'baud': 0}),
    Fault('command cut short before connecting', command_cut_short, keeps_node=False, zero=None),
    Fault('robot at 19200, baud: 0', at_other_rate, keeps_node=False, zero=None),
    Fault('SIGSTOP, SIGCONT', suspended, zero=0.2),
    *map(killed, (signal.SIGKILL, signal.SIGSEGV, signal.SIGABRT)),
    *map(ended, (signal.SIGTERM, signal.SIGINT, signal.SIGHUP)),
    raising('exception in a subscription', publishing(Twist(linear=Vector3(z=1.0)))),
    raising('exception on the serial thread', sending('bump left')),
    Fault('commands end', commands_end, recovery=None, zero=0.7),
    Fault('stop', told_to_stop, recovery=None, zero=0.1),
)
