// Copyright 2026 create_oi_ros contributors
// SPDX-License-Identifier: Apache-2.0
// Tunes: one that is chosen, typed or pasted, and a small piano. Notes that are pressed while a tune
// plays wait for its end, and are the next tune.

import { byId, element } from './dom.js';
import { UNDER_WAY } from './goals.js';
import { say, toast } from './panels.js';

const TUNE = 'audio_note_sequence';
const LOWEST = 67, KEYS = 17;  // G4 and up
const BLACK = new Set([1, 3, 6, 8, 10]);
const NAMES = ['C', 'C sharp', 'D', 'D sharp', 'E', 'F', 'F sharp', 'G', 'G sharp', 'A', 'A sharp', 'B'];
const LENGTH = '1/4';  // seconds of a note on the piano
const PLAYED = 'What you played';
const TUNES = {
  Fanfare: 'G4:0.15 C5:0.15 E5:0.15 G5:0.3',
  'Ode to Joy': 'Joy:d=4,o=5,b=180:e,e,f,g,g,f,e,d,c,c,d,e,e.,8d,2d,e,e,f,g,g,f,e,d,c,c,d,e,d.,8c,2c',
  'Frère Jacques': 'Jacques:d=4,o=5,b=160:c,d,e,c,c,d,e,c,e,f,2g,e,f,2g,8g,8a,8g,8f,e,c,8g,8a,8g,8f,e,c,'
    + 'c,g4,2c,c,g4,2c',
  'Für Elise': 'Elise:d=8,o=5,b=125:e6,d#6,e6,d#6,e6,b,d6,c6,4a,p,c,e,a,4b,p,e,g#,b,4c6,p,e,e6,d#6,e6,'
    + 'd#6,e6,b,d6,c6,4a,p,c,e,a,4b,p,e,c6,b,2a',
};

export class Music {
  constructor(send) {
    this.send = send;
    this.played = [];      // on the piano
    this.waiting = [];     // notes
    this.asked = false;    // whether a tune of this page has not ended
    this.busy = false;     // whether any page's tune plays
    this.playing = false;  // whether the robot says that it plays
    this.name = byId('tune-name');
    this.line = byId('tune-text');
    for (const name of [...Object.keys(TUNES), PLAYED]) this.name.add(new Option(name));
    this.name.addEventListener('change', () => this.choose());
    byId('tune-form').addEventListener('submit', event => {
      event.preventDefault();
      this.play(this.line.value);
    });
    byId('tune-cancel').addEventListener('click', () => this.send('cancel', { what: 'tune' }));
    this.buildPiano(byId('piano'));
    this.choose();
  }

  choose() {
    this.line.value = TUNES[this.name.value] || this.played.join(' ');
  }

  buildPiano(place) {
    this.keys = Array.from({ length: KEYS }, (_, at) => {
      const note = LOWEST + at, step = note % 12;
      const key = element(place, 'button', {
        type: 'button', className: BLACK.has(step) ? 'black' : 'white',
        ariaLabel: `${NAMES[step]} ${Math.floor(note / 12) - 1}`,
        tabIndex: at ? -1 : 0 });  // arrow keys go from key to key
      key.dataset.arrows = '';
      key.addEventListener('click', () => {
        this.played.push(`${note}:${LENGTH}`);
        if (this.name.value === PLAYED) this.choose();
        this.play(`${note}:${LENGTH}`);
      });
      return key;
    });
    place.addEventListener('keydown', event => {
      const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
      const at = this.keys.indexOf(event.target);
      if (step && at >= 0) {
        event.preventDefault();
        this.focus(at + step);
      }
    });
  }

  focus(at) {
    const key = this.keys[Math.min(this.keys.length - 1, Math.max(0, at))];
    for (const each of this.keys) each.tabIndex = each === key ? 0 : -1;
    key.focus();
  }

  play(notes) {
    this.waiting.push(notes);
    this.next();
  }

  next() {
    if (this.asked || this.busy || this.playing || !this.waiting.length) return;
    this.begun = false;
    this.asked = this.send(TUNE, { notes: this.waiting.splice(0).join(' ') });
  }

  // The tune of this page has ended, or was refused.
  answered(to, ok, text) {
    if (to !== TUNE) return false;
    this.asked = false;
    if (!ok) this.waiting = [];
    if (!ok && !this.begun) toast(text, false);
    this.next();
    return true;
  }

  // The newest tune, of whatever page.
  show({ state, text, feedback }) {
    if (this.busy && state === 'ended') toast(text, false);
    this.busy = UNDER_WAY.includes(state);
    this.begun ||= this.busy;
    byId('tune-cancel').disabled = !this.busy || state === 'canceling';
    say('tune-note', !this.busy ? '' : feedback ? `♪ ${feedback.note}, note ${feedback.place + 1}` : '♪');
    this.next();
  }

  sing({ playing }) {
    this.playing = playing;
    this.next();
  }
}
