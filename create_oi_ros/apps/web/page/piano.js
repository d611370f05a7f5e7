// Copyright 2026 create_oi_ros contributors
// SPDX-License-Identifier: Apache-2.0
// A small piano: each key plays one note on the robot, and the last ones can be played again. Notes
// that are pressed while a song plays wait for its end, and are the next song.

const LOWEST = 67, KEYS = 17;  // G4 and up
const BLACK = new Set([1, 3, 6, 8, 10]);
const NAMES = ['C', 'C sharp', 'D', 'D sharp', 'E', 'F', 'F sharp', 'G', 'G sharp', 'A', 'A sharp', 'B'];
const NOTE = 0.25;      // seconds
const MOST = 16;        // notes of a song
const TUNE = [[67, 0.15], [72, 0.15], [76, 0.15], [79, 0.3]];

export class Piano {
  constructor(place, tune, replay, send) {
    this.send = send;
    this.played = [];
    this.waiting = [];     // notes
    this.asked = false;    // whether the robot has not answered yet
    this.until = 0;        // when the last song ends, ms
    this.playing = false;  // whether the robot says that it plays
    this.keys = [];
    for (let note = LOWEST; note < LOWEST + KEYS; note += 1) {
      const key = document.createElement('button');
      const step = note % 12;
      key.className = BLACK.has(step) ? 'black' : 'white';
      key.setAttribute('aria-label', `${NAMES[step]} ${Math.floor(note / 12) - 1}`);
      key.tabIndex = note === LOWEST ? 0 : -1;  // arrow keys go from key to key
      key.dataset.arrows = '';
      key.addEventListener('click', () => {
        this.played = [...this.played, [note, NOTE]].slice(-MOST);
        replay.disabled = false;
        this.play([[note, NOTE]]);
      });
      this.keys.push(key);
      place.append(key);
    }
    place.addEventListener('keydown', event => {
      const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
      const at = this.keys.indexOf(event.target);
      if (step && at >= 0) {
        event.preventDefault();
        this.focus(at + step);
      }
    });
    tune.addEventListener('click', () => this.play(TUNE));
    replay.addEventListener('click', () => {
      this.play(this.played);
      this.played = [];
      replay.disabled = true;
    });
  }

  play(notes) {
    this.waiting.push(...notes);
    this.next();
  }

  next() {
    const left = this.until - performance.now();
    if (this.asked || this.playing || !this.waiting.length) return;
    if (left > 0) { setTimeout(() => this.next(), left); return; }
    this.sent = this.waiting.splice(0, MOST);
    this.asked = this.send(this.sent);
  }

  answered(ok) {
    this.asked = false;
    const seconds = this.sent.reduce((sum, [, each]) => sum + each, 0);
    if (ok) this.until = performance.now() + 1000 * seconds;
    else this.waiting = [];
    this.next();
  }

  show({ playing }) {
    this.playing = playing;
    this.next();
  }

  focus(at) {
    const key = this.keys[Math.min(this.keys.length - 1, Math.max(0, at))];
    for (const each of this.keys) each.tabIndex = each === key ? 0 : -1;
    key.focus();
  }
}
