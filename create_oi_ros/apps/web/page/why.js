// Copyright 2026 create_oi_ros contributors
// SPDX-License-Identifier: Apache-2.0
// Why the robot does not move, in words for people, and what helps: a button's name, a message.

const DRIVABLE = ['SAFE', 'FULL'];
const SAFE = ['Safe', 'set_mode', { mode: 2 }];
const SLOW = 0.8;       // part of the oldest picture that may drive, from which a command may be late
const STANDS = 1.5;     // seconds of pushing without a movement
const STILL = [0.01, 0.03];  // m/s and rad/s
const WHEELS = { left: 'left wheel', right: 'right wheel', caster: 'caster',
                 left_wheel: 'left wheel', right_wheel: 'right wheel' };

// The names of what is on, in words; empty if nothing is.
export function named(sides = {}) {
  return Object.keys(sides).filter(side => sides[side]).map(
    side => WHEELS[side] || side.replaceAll('_', ' ')).join(' and ');
}

// `robot` has the newest parts that the server told, `link` is the connection, and `push` is what
// the user asks for: forward, and since when. Returns null, or words and perhaps a button.
export function whyNot(robot, link, push) {
  if (!link.live) return ['no connection: wheels that the stick drove have stopped'];
  if (!robot.driver_found) return ['no driver runs'];
  if (robot.silent) return ['the driver sends nothing'];
  const slow = link.roundTrip / 1000;
  if (slow > SLOW * robot.oldestView) return [`connection too slow to drive (${slow.toFixed(1)} s)`];
  const { driver, device, stopped } = robot.seat || {};
  if (driver && driver !== robot.you) return [`the ${device} drives`, 'Take over', 'take_over'];
  return inMode(robot, robot.mode) || whilePushed(robot, push, stopped);
}

function inMode(robot, mode) {
  if (!mode || DRIVABLE.includes(mode.actual) || robot.goalRuns) return null;
  const hangs = named(robot.drop), cliff = named(robot.cliff);
  if (robot.charging?.home_base) return ['on its dock', 'Leave the dock', 'undock'];
  if (robot.charging?.internal_charger) return ['the charger is plugged in: pull its plug'];
  if (hangs) return [`${hangs.includes('and') ? 'it' : hangs} hangs in the air: put the robot down`];
  if (cliff) return [`cliff ${cliff}: pull the robot back`];
  const name = mode.actual[0] + mode.actual.slice(1).toLowerCase();
  if (!mode.reason || mode.actual === mode.wanted) return [name, ...SAFE];
  const hung = mode.reason.split(', ').filter(each => each.endsWith(' dropped'));
  if (hung.length) {
    const what = hung.length > 1 ? 'it was lifted' : hung[0].replace('dropped', 'hung');
    return [`${what}; it stands again`, ...SAFE];
  }
  if (mode.reason.startsWith('cliff')) return [`${mode.reason}; there is floor again`, ...SAFE];
  return [`${name}: ${mode.reason}`, ...SAFE];
}

function whilePushed(robot, push, stopped) {
  const blocked = named({ left_wheel: robot.overcurrent?.left_wheel,
                          right_wheel: robot.overcurrent?.right_wheel });
  if (blocked) return [`${blocked} blocked: free it`];
  if (!push.since) return null;
  if (stopped) return ['STOP was pressed: let go first'];
  const bumped = robot.bump?.left || robot.bump?.right;
  if (bumped && push.forward > 0) return ['bumper pressed: back off'];
  const still = Math.abs(robot.pose?.speed ?? 0) < STILL[0] && Math.abs(robot.pose?.turn ?? 0) < STILL[1];
  const long = performance.now() - push.since > 1000 * STANDS;
  return still && long ? ['the wheels stand: is something in the way?'] : null;
}
