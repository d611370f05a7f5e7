# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
Bytes typed by hand from the manual: the outside witness of the declarations.

Nothing here is computed from `create_oi_ros.oi`, and nothing here may be. A table that feeds
encoder, decoder and simulator agrees with itself even where it is wrong; these bytes do not.
Some bytes the manual itself prints; the rest were worked out from its text with pencil and paper.
Values are chosen so that sign, byte order and field order show.
"""

from create_oi_ros import oi


def octets(text: str) -> bytes:
    """Return bytes from decimal numbers separated by spaces, as in the manual."""
    return bytes(int(word) for word in text.split())


DRIVE_40_CM = '137 1 44 128 0 156 1 144 137 0 0 0 0'
TOGGLE_LED_ON_BUMP = '158 5 158 251 139 2 0 0 158 5 158 251 139 0 0 0 153'
DRIVE_IN_A_SQUARE = '137 1 44 128 0 156 1 144 137 1 44 0 1 157 0 90 153'

COMMANDS: list[tuple[oi.Command, bytes]] = [(command, octets(sent)) for command, sent in [
    (oi.Start(), '128'),
    (oi.Baud(code=oi.BaudCode.B300), '129 0'),
    (oi.Baud(code=oi.BaudCode.B19200), '129 7'),
    (oi.Baud(code=oi.BaudCode.B57600), '129 10'),
    (oi.Baud(code=oi.BaudCode.B115200), '129 11'),
    (oi.Control(), '130'),
    (oi.Safe(), '131'),
    (oi.Full(), '132'),
    (oi.Spot(), '134'),
    (oi.Cover(), '135'),
    (oi.Demo(demo=oi.DemoNumber.ABORT), '136 255'),
    (oi.Demo(demo=oi.DemoNumber.COVER), '136 0'),
    (oi.Demo(demo=oi.DemoNumber.BANJO), '136 9'),
    (oi.Drive(velocity=-200, radius=500), '137 255 56 1 244'),  # example
    (oi.Drive(velocity=500, radius=-2000), '137 1 244 248 48'),
    (oi.Drive(velocity=300, radius=oi.Radius.STRAIGHT), '137 1 44 128 0'),
    (oi.Drive(velocity=300, radius=oi.Radius.STRAIGHT_7FFF), '137 1 44 127 255'),
    (oi.Drive(velocity=300, radius=oi.Radius.IN_PLACE_CLOCKWISE), '137 1 44 255 255'),
    (oi.Drive(velocity=300, radius=oi.Radius.IN_PLACE_COUNTER_CLOCKWISE), '137 1 44 0 1'),
    (oi.LowSideDrivers(bits=oi.DriverBits.DRIVER_1), '138 2'),  # example
    (oi.LowSideDrivers(bits=oi.DriverBits.DRIVER_0), '138 1'),
    (oi.LowSideDrivers(bits=oi.DriverBits.DRIVER_2), '138 4'),
    (oi.Leds(bits=oi.LedBits.ADVANCE, color=0, intensity=128), '139 8 0 128'),  # example
    (oi.Leds(bits=oi.LedBits.PLAY, color=255, intensity=1), '139 2 255 1'),
    (oi.Leds(bits=oi.LedBits.PLAY | oi.LedBits.ADVANCE, color=16, intensity=0), '139 10 16 0'),
    (oi.Song(number=15, notes=(oi.Note(31, 32),)), '140 15 1 31 32'),
    (oi.Song(number=2, notes=(oi.Note(60, 64), oi.Note(oi.REST, 16), oi.Note(127, 255))),
     '140 2 3 60 64 0 16 127 255'),
    (oi.PlaySong(number=15), '141 15'),
    (oi.Sensors(packet=6), '142 6'),
    (oi.Sensors(packet=42), '142 42'),
    (oi.CoverAndDock(), '143'),
    (oi.PwmLowSideDrivers(driver_2=32, driver_1=0, driver_0=128), '144 32 0 128'),  # example
    (oi.PwmLowSideDrivers(driver_2=1, driver_1=2, driver_0=3), '144 1 2 3'),
    (oi.PwmLowSideDrivers(driver_2=128, driver_1=128, driver_0=0), '144 128 128 0'),
    (oi.DriveDirect(right=-500, left=258), '145 254 12 1 2'),
    (oi.DriveDirect(right=300, left=-2), '145 1 44 255 254'),
    (oi.DigitalOutputs(bits=oi.OutputBits.OUTPUT_0), '147 1'),
    (oi.DigitalOutputs(bits=oi.OutputBits.OUTPUT_1), '147 2'),
    (oi.DigitalOutputs(bits=oi.OutputBits.OUTPUT_2), '147 4'),
    (oi.Stream(packets=(29, 13)), '148 2 29 13'),  # example
    (oi.Stream(packets=()), '148 0'),
    (oi.QueryList(packets=(9, 13)), '149 2 9 13'),  # example
    (oi.PauseResumeStream(state=oi.StreamState.PAUSE), '150 0'),
    (oi.PauseResumeStream(state=oi.StreamState.RESUME), '150 1'),
    (oi.SendIr(byte=254), '151 254'),
    (oi.Script(script=octets(DRIVE_40_CM)), '152 13 ' + DRIVE_40_CM),  # example
    (oi.Script(script=octets(TOGGLE_LED_ON_BUMP)), '152 17 ' + TOGGLE_LED_ON_BUMP),  # example
    (oi.Script(script=octets(DRIVE_IN_A_SQUARE)), '152 17 ' + DRIVE_IN_A_SQUARE),  # example
    (oi.Script(script=b''), '152 0'),
    (oi.PlayScript(), '153'),
    (oi.ShowScript(), '154'),
    (oi.WaitTime(time=200), '155 200'),
    (oi.WaitDistance(distance=400), '156 1 144'),
    (oi.WaitDistance(distance=-400), '156 254 112'),
    (oi.WaitDistance(distance=-32768), '156 128 0'),
    (oi.WaitAngle(angle=-90), '157 255 166'),
    (oi.WaitAngle(angle=360), '157 1 104'),
    (oi.WaitEvent(event=oi.Event.BUMP), '158 5'),
    (oi.WaitEvent(event=-oi.Event.BUMP), '158 251'),  # example
    (oi.WaitEvent(event=oi.Event.OI_MODE_PASSIVE), '158 22'),
    (oi.WaitEvent(event=-oi.Event.OI_MODE_PASSIVE), '158 234'),
]]
"""Commands and their bytes, by the Open Interface Command Reference; `example`: printed there."""

SCRIPTS: list[tuple[str, list[oi.Command], bytes]] = [
    ('Drive 40 cm and stop', [
        oi.Drive(velocity=300, radius=oi.Radius.STRAIGHT),
        oi.WaitDistance(distance=400),
        oi.Drive(velocity=0, radius=0),
    ], octets('152 13 ' + DRIVE_40_CM)),
    ('Toggle led on bump', [
        oi.WaitEvent(event=oi.Event.BUMP),
        oi.WaitEvent(event=-oi.Event.BUMP),
        oi.Leds(bits=oi.LedBits.PLAY, color=0, intensity=0),
        oi.WaitEvent(event=oi.Event.BUMP),
        oi.WaitEvent(event=-oi.Event.BUMP),
        oi.Leds(bits=oi.LedBits(0), color=0, intensity=0),
        oi.PlayScript(),
    ], octets('152 17 ' + TOGGLE_LED_ON_BUMP)),
    ('Drive in a square', [
        oi.Drive(velocity=300, radius=oi.Radius.STRAIGHT),
        oi.WaitDistance(distance=400),
        oi.Drive(velocity=300, radius=oi.Radius.IN_PLACE_COUNTER_CLOCKWISE),
        oi.WaitAngle(angle=90),
        oi.PlayScript(),
    ], octets('152 17 ' + DRIVE_IN_A_SQUARE)),
]
"""The manual's example scripts (Script Commands): name, commands, bytes."""

_ANY, _STARTED, _ACTUATE = 'off passive safe full', 'passive safe full', 'safe full'
COMMAND_FACTS: dict[int, tuple[str, str, str]] = {
    128: ('Start', _ANY, 'passive'), 129: ('Baud', _STARTED, ''),
    130: ('Control', _STARTED, 'safe'), 131: ('Safe', _STARTED, 'safe'),
    132: ('Full', _STARTED, 'full'), 134: ('Spot', _STARTED, 'passive'),
    135: ('Cover', _STARTED, 'passive'), 136: ('Demo', _STARTED, 'passive'),
    137: ('Drive', _ACTUATE, ''), 138: ('Low Side Drivers', _ACTUATE, ''),
    139: ('LEDs', _ACTUATE, ''), 140: ('Song', _STARTED, ''), 141: ('Play Song', _ACTUATE, ''),
    142: ('Sensors', _STARTED, ''), 143: ('Cover and Dock', _STARTED, 'passive'),
    144: ('PWM Low Side Drivers', _ACTUATE, ''), 145: ('Drive Direct', _ACTUATE, ''),
    147: ('Digital Outputs', _ACTUATE, ''), 148: ('Stream', _STARTED, ''),
    149: ('Query List', _STARTED, ''), 150: ('Pause/Resume Stream', _STARTED, ''),
    151: ('Send IR', _ACTUATE, ''), 152: ('Script', _STARTED, ''),
    153: ('Play Script', _STARTED, ''), 154: ('Show Script', _STARTED, ''),
    155: ('Wait Time', _STARTED, ''), 156: ('Wait Distance', _STARTED, ''),
    157: ('Wait Angle', _STARTED, ''), 158: ('Wait Event', _STARTED, ''),
}
"""By opcode: the manual's name, `Available in modes`, `Changes mode to` (empty: No Change).

Names are headings of the Open Interface Command Reference. Start also works in Off: "once it
receives the Start command" (iRobot Create Open Interface Modes).
"""

OUT_OF_RANGE: list[tuple[oi.Command, str]] = [
    (oi.Baud(code=12), 'code'),
    (oi.Baud(code=-1), 'code'),
    (oi.Demo(demo=10), 'demo'),
    (oi.Demo(demo=-2), 'demo'),
    (oi.Drive(velocity=501, radius=0), 'velocity'),
    (oi.Drive(velocity=-501, radius=0), 'velocity'),
    (oi.Drive(velocity=0, radius=2001), 'radius'),
    (oi.Drive(velocity=0, radius=-2001), 'radius'),
    (oi.LowSideDrivers(bits=8), 'bits'),
    (oi.Leds(bits=1, color=0, intensity=0), 'bits'),
    (oi.Leds(bits=4, color=0, intensity=0), 'bits'),
    (oi.Leds(bits=0, color=256, intensity=0), 'color'),
    (oi.Leds(bits=0, color=0, intensity=-1), 'intensity'),
    (oi.Song(number=16, notes=(oi.Note(60, 1),)), 'number'),
    (oi.Song(number=0, notes=()), 'notes'),
    (oi.Song(number=0, notes=(oi.Note(60, 1),) * 17), 'notes'),
    (oi.Song(number=0, notes=(oi.Note(60, 1), oi.Note(256, 1))), 'notes[1]'),
    (oi.Song(number=0, notes=(oi.Note(60, 256),)), 'notes[0]'),
    (oi.PlaySong(number=16), 'number'),
    (oi.Sensors(packet=43), 'packet'),
    (oi.PwmLowSideDrivers(driver_2=129, driver_1=0, driver_0=0), 'driver_2'),
    (oi.PwmLowSideDrivers(driver_2=0, driver_1=129, driver_0=0), 'driver_1'),
    (oi.PwmLowSideDrivers(driver_2=0, driver_1=0, driver_0=129), 'driver_0'),
    (oi.DriveDirect(right=501, left=0), 'right'),
    (oi.DriveDirect(right=0, left=-501), 'left'),
    (oi.DigitalOutputs(bits=8), 'bits'),
    (oi.DigitalOutputs(bits=-1), 'bits'),
    (oi.Stream(packets=(7,) * 44), 'packets'),
    (oi.Stream(packets=(7, 43)), 'packets[1]'),
    (oi.QueryList(packets=(7,) * 256), 'packets'),
    (oi.QueryList(packets=(43,)), 'packets[0]'),
    (oi.PauseResumeStream(state=2), 'state'),
    (oi.SendIr(byte=256), 'byte'),
    (oi.Script(script=bytes(101)), 'script'),
    (oi.WaitTime(time=256), 'time'),
    (oi.WaitDistance(distance=32768), 'distance'),
    (oi.WaitAngle(angle=-32769), 'angle'),
    (oi.WaitEvent(event=0), 'event'),
    (oi.WaitEvent(event=23), 'event'),
    (oi.WaitEvent(event=-23), 'event'),
]
"""Commands with one value just outside its range in the manual, and the name of that field."""

PACKETS = [(number, octets(sent), value) for number, sent, value in [
    (7, '0', oi.BumpsAndWheelDrops(0)),
    (7, '1', oi.BumpsAndWheelDrops.BUMP_RIGHT),
    (7, '2', oi.BumpsAndWheelDrops.BUMP_LEFT),
    (7, '4', oi.BumpsAndWheelDrops.WHEEL_DROP_RIGHT),
    (7, '8', oi.BumpsAndWheelDrops.WHEEL_DROP_LEFT),
    (7, '16', oi.BumpsAndWheelDrops.WHEEL_DROP_CASTER),
    (8, '0', False), (8, '1', True),
    (9, '0', False), (9, '1', True),
    (10, '0', False), (10, '1', True),
    (11, '0', False), (11, '1', True),
    (12, '0', False), (12, '1', True),
    (13, '0', False), (13, '1', True),
    (14, '1', oi.Overcurrents.DRIVER_1),
    (14, '2', oi.Overcurrents.DRIVER_0),
    (14, '4', oi.Overcurrents.DRIVER_2),
    (14, '8', oi.Overcurrents.RIGHT_WHEEL),
    (14, '16', oi.Overcurrents.LEFT_WHEEL),
    (15, '0', 0), (15, '128', 128),
    (16, '0', 0), (16, '128', 128),
    (17, '255', oi.Infrared.NONE),
    (17, '254', oi.Infrared.HOME_BASE_RED_BUOY_GREEN_BUOY_AND_FORCE_FIELD),
    (17, '7', 7),
    (18, '1', oi.Buttons.PLAY), (18, '4', oi.Buttons.ADVANCE),
    (19, '255 56', -200), (19, '1 244', 500),
    (20, '255 166', -90), (20, '1 104', 360),
    (21, '0', oi.ChargingState.NOT_CHARGING),
    (21, '5', oi.ChargingState.FAULT),
    (22, '62 128', 16000), (22, '255 254', 65534),
    (23, '252 24', -1000), (23, '5 220', 1500),
    (24, '251', -5), (24, '25', 25),
    (25, '11 184', 3000), (25, '255 254', 65534),
    (26, '10 140', 2700), (26, '255 254', 65534),
    (27, '15 254', 4094), (27, '128 1', 32769),
    (28, '15 253', 4093), (28, '128 1', 32769),
    (29, '2 37', 549), (29, '128 1', 32769),
    (30, '1 2', 258), (30, '128 1', 32769),
    (31, '3 4', 772), (31, '128 1', 32769),
    (32, '1', oi.DigitalInputs.INPUT_0),
    (32, '2', oi.DigitalInputs.INPUT_1),
    (32, '4', oi.DigitalInputs.INPUT_2),
    (32, '8', oi.DigitalInputs.INPUT_3),
    (32, '16', oi.DigitalInputs.BAUD_RATE_CHANGE),
    (33, '3 254', 1022), (33, '128 1', 32769),
    (34, '1', oi.ChargingSources.INTERNAL_CHARGER),
    (34, '2', oi.ChargingSources.HOME_BASE),
    (35, '0', oi.Mode.OFF), (35, '1', oi.Mode.PASSIVE),
    (35, '2', oi.Mode.SAFE), (35, '3', oi.Mode.FULL),
    (36, '15', 15), (36, '200', 200),
    (37, '0', False), (37, '1', True),
    (38, '43', 43), (38, '200', 200),
    (39, '254 12', -500), (39, '1 244', 500),
    (40, '248 48', -2000), (40, '7 208', 2000),
    (40, '128 0', -32768),
    (41, '255 56', -200), (41, '1 44', 300),
    (42, '254 212', -300), (42, '0 200', 200),
]]
"""Sensor packets 7 to 42. Values above the manual's range show that a packet is unsigned."""

GROUPS: dict[int, tuple[int, int, int]] = {
    0: (26, 7, 26), 1: (10, 7, 16), 2: (6, 17, 20), 3: (10, 21, 26), 4: (14, 27, 34),
    5: (12, 35, 42), 6: (52, 7, 42),
}
"""Group Packet Sizes and Contents: bytes, first and last packet that it contains."""


RANGES: dict[int, tuple[int, int]] = {
    7: (0, 31), 8: (0, 1), 9: (0, 1), 10: (0, 1), 11: (0, 1), 12: (0, 1), 13: (0, 1),
    14: (0, 31), 15: (0, 0), 16: (0, 0), 17: (0, 255), 18: (0, 5), 19: (-32768, 32767),
    20: (-32768, 32767), 21: (0, 5), 22: (0, 65535), 23: (-32768, 32767), 24: (-128, 127),
    25: (0, 65535), 26: (0, 65535), 27: (0, 4095), 28: (0, 4095), 29: (0, 4095), 30: (0, 4095),
    31: (0, 4095), 32: (0, 31), 33: (0, 1023), 34: (0, 3), 35: (0, 3), 36: (0, 15), 37: (0, 1),
    38: (0, 43), 39: (-500, 500), 40: (-32768, 32767), 41: (-500, 500), 42: (-500, 500),
}
"""iRobot Create Open Interface Sensor Packets: Range, by packet."""

STREAM_FRAME = octets('19 5 29 2 25 13 0 182')
"""Stream, the manual's example; its checksum leaves the header out.

The manual's text reads its "2 25" as hexadecimal, which is 549. The checksum of 182 shows that the
bytes are decimal: the value is 2 * 256 + 25 = 537.
"""
STREAM_VALUES = {'cliff_front_left_signal': 537, 'virtual_wall': False}
STREAM_FRAME_OF_REAL_ROBOTS = octets('19 5 29 2 25 13 0 163')
"""The same frame with the header in the checksum: 19 + 5 + 29 + 2 + 25 + 13 + 0 + 163 = 256."""

STREAM_CAPACITY = {57600: 86, 19200: 28}
"""Bytes in 15 ms by baud rate (Stream; for 19200 calculated in the same way: 28.8)."""

BAUD_CODES = {
    0: 300, 1: 600, 2: 1200, 3: 2400, 4: 4800, 5: 9600, 6: 14400, 7: 19200, 8: 28800, 9: 38400,
    10: 57600, 11: 115200,
}
"""Baud: bits per second by code."""

NAMED_NUMBERS: dict[str, dict[int, str]] = {
    'Mode': {0: 'OFF', 1: 'PASSIVE', 2: 'SAFE', 3: 'FULL'},
    'DemoNumber': {
        -1: 'ABORT', 0: 'COVER', 1: 'COVER_AND_DOCK', 2: 'SPOT_COVER', 3: 'MOUSE',
        4: 'DRIVE_FIGURE_EIGHT', 5: 'WIMP', 6: 'HOME', 7: 'TAG', 8: 'PACHELBEL', 9: 'BANJO',
    },
    'Radius': {
        -0x8000: 'STRAIGHT', 0x7fff: 'STRAIGHT_7FFF', -1: 'IN_PLACE_CLOCKWISE',
        1: 'IN_PLACE_COUNTER_CLOCKWISE',
    },
    'StreamState': {0: 'PAUSE', 1: 'RESUME'},
    'Event': {
        1: 'WHEEL_DROP', 2: 'FRONT_WHEEL_DROP', 3: 'LEFT_WHEEL_DROP', 4: 'RIGHT_WHEEL_DROP',
        5: 'BUMP', 6: 'LEFT_BUMP', 7: 'RIGHT_BUMP', 8: 'VIRTUAL_WALL', 9: 'WALL', 10: 'CLIFF',
        11: 'LEFT_CLIFF', 12: 'FRONT_LEFT_CLIFF', 13: 'FRONT_RIGHT_CLIFF', 14: 'RIGHT_CLIFF',
        15: 'HOME_BASE', 16: 'ADVANCE_BUTTON', 17: 'PLAY_BUTTON', 18: 'DIGITAL_INPUT_0',
        19: 'DIGITAL_INPUT_1', 20: 'DIGITAL_INPUT_2', 21: 'DIGITAL_INPUT_3',
        22: 'OI_MODE_PASSIVE',
    },
    'ChargingState': {
        0: 'NOT_CHARGING', 1: 'RECONDITIONING', 2: 'FULL_CHARGING', 3: 'TRICKLE', 4: 'WAITING',
        5: 'FAULT',
    },
    'Infrared': {
        129: 'REMOTE_LEFT', 130: 'REMOTE_FORWARD', 131: 'REMOTE_RIGHT', 132: 'REMOTE_SPOT',
        133: 'REMOTE_MAX', 134: 'REMOTE_SMALL', 135: 'REMOTE_MEDIUM', 136: 'REMOTE_LARGE_CLEAN',
        137: 'REMOTE_PAUSE', 138: 'REMOTE_POWER', 139: 'REMOTE_ARC_FORWARD_LEFT',
        140: 'REMOTE_ARC_FORWARD_RIGHT', 141: 'REMOTE_DRIVE_STOP', 142: 'SCHEDULING_SEND_ALL',
        143: 'SCHEDULING_SEEK_DOCK', 240: 'HOME_BASE_RESERVED', 248: 'HOME_BASE_RED_BUOY',
        244: 'HOME_BASE_GREEN_BUOY', 242: 'HOME_BASE_FORCE_FIELD',
        252: 'HOME_BASE_RED_BUOY_AND_GREEN_BUOY', 250: 'HOME_BASE_RED_BUOY_AND_FORCE_FIELD',
        246: 'HOME_BASE_GREEN_BUOY_AND_FORCE_FIELD',
        254: 'HOME_BASE_RED_BUOY_GREEN_BUOY_AND_FORCE_FIELD', 255: 'NONE',
    },
    'LedBits': {2: 'PLAY', 8: 'ADVANCE'},
    'DriverBits': {1: 'DRIVER_0', 2: 'DRIVER_1', 4: 'DRIVER_2'},
    'OutputBits': {1: 'OUTPUT_0', 2: 'OUTPUT_1', 4: 'OUTPUT_2'},
}
"""The enumerations: OI Mode, Demo, Drive, Pause/Resume Stream, Wait Event, Charging State,
Infrared Byte, LEDs, Low Side Drivers, Digital Outputs. (Bits of packets are in PACKETS.)"""


NOTES: dict[int, tuple[str, float]] = {
    31: ('G', 49.0), 32: ('G#', 51.0), 33: ('A', 55.0), 34: ('A#', 58.3), 35: ('B', 61.7),
    36: ('C', 65.4), 37: ('C#', 69.3), 38: ('D', 73.4), 39: ('D#', 77.8), 40: ('E', 82.4),
    41: ('F', 87.3), 42: ('F#', 92.5), 43: ('G', 98.0), 60: ('C', 261.6), 69: ('A', 440.0),
    72: ('C', 523.3), 95: ('B', 1975.5), 126: ('F#', 11839.8), 127: ('G', 12543.9),
}
"""Note Durations (Song): name and frequency, of the first octave and some of the others, by note
number; the frequency of 32 is a misprint (51.9)."""
