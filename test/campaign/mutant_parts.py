# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
The files whose mutants are tried, and the tests that must find them, the quickest first.

`test_campaign.py` checks that no file of the rooms below is forgotten.
"""

ROOMS = 'oi', 'driver', 'driver/goals', 'odometry'
"""Rooms of which every file is tried."""
NO_MUTANTS = {'driver/health'}
"""Files that decide and calculate nothing."""
GOALS = 'driver/goals'
TEXT = 'oi/test_commands.py', 'oi/test_text.py'
BYTES = 'oi/test_commands.py', 'oi/test_packets.py', 'oi/test_text.py'
FRAMES = 'oi/test_packets.py', 'oi/test_stream.py'
MACHINE = ('driver/test_connection.py', 'driver/test_script_steps.py', 'driver/test_modes.py',
           'driver/test_velocity.py', 'driver/test_lost_commands.py',
           'driver/test_reliability.py')
SCRIPTS = ('driver/test_script_steps.py', 'driver/test_script_requests.py')
BATTERY = 'driver/test_battery_watch.py', 'driver/test_reliability.py'
TRACKS = ('odometry/test_tracks.py', 'odometry/test_knowledge.py', 'odometry/test_assumptions.py',
          'odometry/test_wheel_model.py', 'odometry/test_wheel_sums.py')
PARTS = {
    'link/dead_man': ('link/test_dead_man.py',),
    'link/dead_man_process': ('link/test_dead_man.py',),
    'oi/stream': ('oi/test_stream_limits.py', 'oi/test_stream.py'),
    'oi/steering': ('oi/test_steering.py',),
    'oi/script': ('oi/test_commands.py', 'oi/test_text.py', 'oi/test_stream.py'),
    'oi/script_motion': ('oi/test_script_motion.py',),
    'oi/wire': BYTES,
    'oi/declaration': TEXT,
    'oi/commands': ('oi/test_commands.py',),
    'oi/packets': FRAMES,
    'oi/readings': FRAMES,
    'oi/codes': ('oi/test_commands.py', 'oi/test_packets.py'),
    'driver/motion': ('driver/test_motion.py', 'driver/test_velocity.py'),
    'driver/velocity_control': ('driver/test_velocity.py', 'driver/test_modes.py'),
    'driver/supervision': ('driver/test_supervision.py', 'driver/test_modes.py'),
    'driver/state': ('driver/test_state.py',),
    'driver/modes': ('driver/test_modes.py', 'driver/test_lost_commands.py'),
    'driver/outbox': ('driver/test_outbox.py', 'driver/test_requests.py'),
    'driver/requests': ('driver/test_requests.py',),
    'driver/goal_control': ('driver/test_goal_control.py', 'driver/test_goal_endings.py'),
    'driver/frame_clock': ('driver/test_frame_clock.py',),
    'driver/plausibility': ('driver/test_plausibility.py',),
    'driver/machine': MACHINE,
    'driver/connection': ('driver/test_connection.py', 'driver/test_calling.py'),
    'driver/stopping': ('driver/test_stopping.py',),
    'driver/tracking': ('driver/test_tracking.py',),
    'driver/command_watch': ('driver/test_line_watch.py',),
    'driver/frame_budget': ('driver/test_line_watch.py',),
    'driver/baud_search': ('driver/test_line_watch.py',),
    'driver/waiting_frames': ('driver/test_waiting_frames.py',),
    'driver/stream_plan': ('driver/test_line_watch.py',),
    'driver/script_control': SCRIPTS,
    'driver/script_speeds': ('driver/test_script_speeds.py',),
    'driver/outputs': ('driver/test_requests.py',),
    'driver/demos': ('driver/test_demo_steps.py',),
    'driver/pending': ('driver/test_pending.py', 'driver/test_requests.py'),
    'driver/events': ('driver/test_driver.py',),
    'driver/settings': ('driver/test_driver.py',),
    'driver/battery_watch': BATTERY,
    'driver/battery_guard': BATTERY,
    'driver/charge_watch': ('driver/test_battery_watch.py',),
    'driver/acquaintance': ('driver/test_acquaintance.py',),
    'driver/contacts': ('driver/test_contacts.py',),
    f'{GOALS}/approach': ('driver/test_approach.py',),
    f'{GOALS}/legs': ('driver/test_legs.py',),
    f'{GOALS}/hazards': ('driver/test_hazards.py',),
    f'{GOALS}/wall_following': ('driver/test_hazards.py',),
    f'{GOALS}/docking': ('driver/test_dock_steps.py',),
    f'{GOALS}/motions': ('driver/test_motion_steps.py',),
    f'{GOALS}/goal': ('driver/test_motion_steps.py',),
    f'{GOALS}/outcome': ('driver/test_motion_steps.py', 'driver/test_goal_control.py'),
    'odometry/rounding': ('odometry/test_rounding.py',),
    'odometry/accumulators': ('odometry/test_accumulators.py',),
    'odometry/dead_band': ('odometry/test_dead_band.py',),
    'odometry/assumptions': ('odometry/test_assumptions.py',),
    'odometry/filter': ('odometry/test_disturbed_odometry.py', 'odometry/test_hindsight.py'),
    'odometry/hindsight': ('odometry/test_hindsight.py',),
    'odometry/doubt': ('odometry/test_doubt.py',),
    'odometry/estimate': ('odometry/test_plain.py',),
    'odometry/knowledge': ('odometry/test_knowledge.py',),
    'odometry/noise': ('odometry/test_noise.py',),
    'odometry/obedience': ('odometry/test_obedience.py',),
    'odometry/odometry': ('odometry/test_following.py', 'odometry/test_disturbed_odometry.py',
                          'odometry/test_odometry.py'),
    'odometry/plain': ('odometry/test_plain.py',),
    'odometry/reading_plan': ('odometry/test_reading_plan.py', 'odometry/test_questions.py'),
    'odometry/mark': ('odometry/test_mark.py',),
    'odometry/mean_pose': ('odometry/test_mean_pose.py',),
    'odometry/request_history': ('odometry/test_request_history.py',),
    'odometry/encoder_signs': ('odometry/test_encoder_signs.py',),
    'odometry/lags': TRACKS,
    'odometry/springs': TRACKS,
    'odometry/states': ('odometry/test_states.py',),
    'odometry/tracks': ('odometry/test_track_sums.py', 'odometry/test_questions.py', *TRACKS),
    'odometry/wheel_model': TRACKS,
}
"""By file of the package."""
