// Copyright 2026 create_oi_ros contributors
// SPDX-License-Identifier: Apache-2.0
// The live connection: it comes back by itself, and knows how old the newest picture is.

const RETRY = 1000;  // ms
const CLOSED = {
  1008: 'This page sent too many messages. Load it again.',
  1013: 'Too many pages are open already. Close one, then load this page again.',
};

export class Connection {
  constructor(onMessage, onState) {
    this.onMessage = onMessage;
    this.onState = onState;
    this.seen = 0;  // the server's time of the newest news
    this.open();
  }

  open() {
    const scheme = location.protocol === 'https:' ? 'wss' : 'ws';
    this.socket = new WebSocket(`${scheme}://${location.host}/live`);
    this.socket.addEventListener('open', () => this.onState(true, ''));
    this.socket.addEventListener('message', event => {
      const message = JSON.parse(event.data);
      if (message.at) this.seen = message.at;
      this.onMessage(message);
    });
    this.socket.addEventListener('close', event => {
      this.onState(false, CLOSED[event.code] || '');
      if (!CLOSED[event.code]) setTimeout(() => this.open(), RETRY);
    });
  }

  send(type, fields = {}) {
    if (this.socket.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify({ type, ...fields }));
    return true;
  }
}
