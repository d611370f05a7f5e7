// Copyright 2026 create_oi_ros contributors
// SPDX-License-Identifier: Apache-2.0
// Driving: a stick for thumb or mouse, keys, a gamepad. The command repeats while one is held.

const PERIOD = 50;  // ms between two commands
const DEAD = 0.08;  // part of the stick's way that does nothing
const KEYS = {
  ArrowUp: [1, 0], ArrowDown: [-1, 0], ArrowLeft: [0, 1], ArrowRight: [0, -1],
  KeyW: [1, 0], KeyS: [-1, 0], KeyA: [0, 1], KeyD: [0, -1],
};
const KEY_TURN = 0.6;  // keys turn slower than a stick that is pushed to its end
const PAD_DEAD = 0.15; // part of a gamepad's way that counts as let go: sticks do not rest at 0
const PAD_SAME = 3000; // ms without any change after which a gamepad counts as gone
const PAD_STOPS = 4;   // buttons of a gamepad that mean STOP: the first ones
const TURN_PER_SPEED = 4;  // rad/s for each m/s of the speed limit

export class Stick {
  constructor(pad, knob, limit, connection, topTurn, onStop) {
    Object.assign(this, { pad, knob, limit, connection, topTurn, onStop });
    this.forward = 0;  // -1 to 1
    this.turn = 0;     // -1 to 1, left is positive
    this.pointer = null;
    this.pressed = new Set();
    this.timer = null;
    this.since = null;        // when the user began to push
    this.padRested = false;   // whether the gamepad was let go since the last end
    this.padDrives = this.padStops = false;
    setInterval(() => this.readGamepad(), PERIOD);
    pad.addEventListener('pointerdown', event => this.grab(event));
    pad.addEventListener('pointermove', event => this.drag(event));
    for (const end of ['pointerup', 'pointercancel', 'lostpointercapture']) {
      pad.addEventListener(end, event => {
        if (event.pointerId === this.pointer) this.letGo();
      });
    }
    addEventListener('keydown', event => this.keyDown(event));
    addEventListener('keyup', event => this.keyUp(event));
    // A page that nobody sees or types into must not drive.
    addEventListener('blur', () => this.letGo());
    addEventListener('pagehide', () => this.letGo());
    document.addEventListener('visibilitychange', () => {
      if (document.hidden) this.letGo();
    });
    pad.addEventListener('contextmenu', event => event.preventDefault());
  }

  grab(event) {
    if (this.pointer !== null || event.button !== 0) return;
    event.preventDefault();
    document.activeElement.blur();  // so that space means STOP from now on
    this.pad.setPointerCapture(event.pointerId);
    this.pressed.clear();
    this.pointer = event.pointerId;
    this.drag(event);
  }

  drag(event) {
    if (event.pointerId !== this.pointer) return;
    const box = this.pad.getBoundingClientRect();
    const reach = box.width / 2 * 0.72;
    let x = (event.clientX - box.left - box.width / 2) / reach;
    let y = (event.clientY - box.top - box.height / 2) / reach;
    const far = Math.hypot(x, y);
    if (far > 1) { x /= far; y /= far; }
    this.set(-y, -x);
  }

  keyDown(event) {
    if (!KEYS[event.code] || event.ctrlKey || event.altKey || event.metaKey) return;
    if (event.target.closest('input, [data-arrows]')) return;
    event.preventDefault();
    if (this.pointer !== null || event.repeat) return;
    document.activeElement.blur();
    this.pressed.add(event.code);
    this.fromKeys();
  }

  keyUp(event) {
    if (this.pressed.delete(event.code)) this.fromKeys();
  }

  fromKeys() {
    let forward = 0, turn = 0;
    for (const key of this.pressed) {
      forward += KEYS[key][0];
      turn += KEYS[key][1];
    }
    if (this.pressed.size) this.set(Math.sign(forward), Math.sign(turn) * KEY_TURN);
    else this.letGo();
  }

  // A gamepad drives as the stick does: while it is pushed, and while this page is looked at. After
  // every end it must have been let go before it drives again.
  readGamepad() {
    const looked = !document.hidden && document.hasFocus();
    const pad = looked ? [...navigator.getGamepads()].find(each => each?.connected) : null;
    const same = pad && performance.now() - pad.timestamp > PAD_SAME;
    const [x, y] = pad ? pad.axes : [0, 0];
    const stops = Boolean(pad?.buttons.slice(0, PAD_STOPS).some(button => button.pressed));
    if (stops && !this.padStops) this.onStop();
    this.padStops = stops;
    const rests = Math.hypot(x, y) < PAD_DEAD;
    if (this.padDrives && (rests || same)) this.letGo();
    if (pad && rests) this.padRested = true;
    if (rests || same || stops || !this.padRested || this.pointer !== null || this.pressed.size) return;
    this.padDrives = true;
    this.set(-y, -x);
  }

  set(forward, turn) {
    this.forward = Math.abs(forward) < DEAD ? 0 : forward;
    this.turn = Math.abs(turn) < DEAD ? 0 : turn;
    this.show();
    if (this.timer === null) {
      this.since = performance.now();
      this.connection.send('release');  // after STOP, the stick must have been let go
      this.timer = setInterval(() => this.send(), PERIOD);
      this.send();
    }
  }

  send() {
    const top = Number(this.limit.value);
    const fastest = Math.min(this.topTurn(), top * TURN_PER_SPEED);
    this.connection.send('drive', {
      linear: this.forward * top, angular: this.turn * fastest, seen: this.connection.seen,
    });
  }

  letGo() {
    this.pressed.clear();
    this.pointer = this.since = null;
    this.padDrives = this.padRested = false;
    this.forward = this.turn = 0;
    if (this.timer !== null) {
      clearInterval(this.timer);
      this.timer = null;
      this.connection.send('release');
    }
    this.show();
  }

  show() {
    this.pad.classList.toggle('held', this.timer !== null || this.pointer !== null);
    this.knob.style.transform = `translate(${-this.turn * 36}cqw, ${-this.forward * 36}cqw)`;
  }
}
