// Copyright 2026 create_oi_ros contributors
// SPDX-License-Identifier: Apache-2.0
// The live connection: it comes back by itself, and knows how old the newest picture is, and how
// long a word takes there and back. A network can be dead while nobody is told: only news count.

const RETRY = 1000, QUIET = 1000, GIVE_UP = 4000, PING = 1000, LOOK = 200;  // ms
const CLOSED = {
  1008: 'This page sent too many messages; it connects again.',
  1013: 'Too many pages are open already. Close one.',
};
const NEW_TOKEN = 'The server wants another token: it was started again.';

export class Connection {
  constructor(onMessage, onState) {
    this.onMessage = onMessage;
    this.onState = onState;
    this.seen = 0;           // the server's time of the newest news
    this.roundTrip = null;   // ms; null: not known
    this.live = false;       // whether there are news
    this.trouble = '';       // why it is closed, if the server said so
    this.refused = false;    // whether the token is wrong
    this.name = crypto.getRandomValues(new Uint32Array(4)).join('-');
    this.newsAt = performance.now();
    this.open();
    setInterval(() => this.look(), LOOK);
  }

  get quiet() { return (performance.now() - this.newsAt) / 1000; }  // seconds without news

  open() {
    const scheme = location.protocol === 'https:' ? 'wss' : 'ws';
    const socket = new WebSocket(`${scheme}://${location.host}/live?page=${this.name}`);
    let opened = false;
    this.socket = socket;
    this.openedAt = performance.now();
    this.pingAt = null;
    socket.addEventListener('open', () => { opened = true; });
    socket.addEventListener('message', event => {
      if (socket === this.socket) this.receive(JSON.parse(event.data));
    });
    socket.addEventListener('close', event => {
      if (socket !== this.socket) return;  // it was given up before
      this.socket = null;
      this.trouble = CLOSED[event.code] || '';
      if (!opened) this.askWhy();
      setTimeout(() => this.socket || this.open(), this.trouble || this.refused ? 3 * RETRY : RETRY);
      this.look();
    });
  }

  // A browser does not say why it could not connect.
  async askWhy() {
    const answer = await fetch('main.js').catch(() => null);
    this.refused = answer?.status === 401;
    if (this.refused) this.trouble = NEW_TOKEN;
  }

  receive(message) {
    const now = performance.now();
    this.newsAt = now;
    this.trouble = '';
    this.refused = false;
    if (message.at) this.seen = message.at;
    if (message.to === 'ping') {
      this.roundTrip = now - this.pingAt;
      this.pingAt = null;
    } else {
      this.onMessage(message);
    }
    if (!this.live) this.look();
  }

  look() {
    const now = performance.now(), open = this.socket?.readyState === WebSocket.OPEN;
    this.live = open && now - this.newsAt < QUIET;
    if (!open) this.roundTrip = null;
    if (open && this.pingAt !== null) this.roundTrip = Math.max(this.roundTrip, now - this.pingAt);
    if (open && (this.pingAt === null) && now - (this.pingedAt || 0) > PING) {
      this.pingAt = this.pingedAt = now;
      this.send('ping');
    }
    if (this.socket && now - Math.max(this.newsAt, this.openedAt) > GIVE_UP) {
      this.socket.close();
      this.open();
    }
    this.onState();
  }

  send(type, fields = {}) {
    if (this.socket?.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify({ type, ...fields }));
    return true;
  }
}
