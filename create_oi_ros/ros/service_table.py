"""The services, declared once: name, type, what they do."""

from dataclasses import dataclass

from create_oi_msgs.srv import (
    DefineScript,
    DefineSong,
    PlayScript,
    PlaySong,
    SendIr,
    SetDigitalOutputs,
    SetLeds,
    SetLowSideDrivers,
    SetMode,
    ShowScript,
    StartDemo,
)
from std_srvs.srv import Trigger


@dataclass(frozen=True, kw_only=True)
class Service:
    """One service; `answers.Answers` has a method of the same name."""

    name: str
    type: type
    about: str


SERVICES = (
    Service(
        name='set_mode', type=SetMode,
        about='enter Passive (1), Safe (2) or Full (3); answers when the robot reports it'),
    Service(
        name='stop', type=Trigger,
        about='stop the wheels, and a demo, before anything else is sent'),
    Service(
        name='reset_odometry', type=Trigger, about='begin `odom` again where the robot is'),
    Service(
        name='define_song', type=DefineSong,
        about='store a song as MIDI numbers and seconds, and play it if `play` is set'),
    Service(name='play_song', type=PlaySong, about='play a song that was stored'),
    Service(
        name='set_leds', type=SetLeds, about='Play and Advance; colour and intensity of Power'),
    Service(
        name='set_digital_outputs', type=SetDigitalOutputs,
        about='the three digital outputs of the cargo bay'),
    Service(
        name='set_low_side_drivers', type=SetLowSideDrivers,
        about='duty cycles of the three low side drivers, 0.0 (off) to 1.0 (on)'),
    Service(
        name='send_ir', type=SendIr, about='send an infrared character by low side driver 1'),
    Service(
        name='start_demo', type=StartDemo,
        about='let the robot play a built-in demo, 0 (Cover) to 9 (Banjo)'),
    Service(name='stop_demo', type=Trigger, about='end the demo; the robot stays in Passive'),
    Service(name='dock', type=Trigger, about='look for the Home Base and charge there'),
    Service(
        name='define_script', type=DefineScript,
        about='store a script, as lines of text or as bytes'),
    Service(
        name='play_script', type=PlayScript,
        about='play the stored script; one that cannot end only by `force`'),
    Service(name='show_script', type=ShowScript, about='read the stored script back'),
)
