// Copyright 2026 create_oi_ros contributors
// SPDX-License-Identifier: Apache-2.0
// What the page says in words. All text goes in as text, never as HTML.

import { byId, element } from './dom.js';

const WARN = 1, ERROR = 2;
const MOST_LOGGED = 200;

export function say(id, text) {
  const element = byId(id);
  if (element.textContent !== text) element.textContent = text;
}

function chip(id, text, level = '') {
  say(id, text);
  byId(id).hidden = !text;
  byId(id).dataset.level = level;
}

function span(minutes) {
  if (minutes < 60) return `${minutes} min`;
  return `${Math.floor(minutes / 60)} h ${String(minutes % 60).padStart(2, '0')} min`;
}

function number(value, digits, unit) {
  return value === null ? 'not known' : `${value.toFixed(digits)} ${unit}`;
}

export function showMode({ actual, wanted, reason }) {
  const differs = actual !== wanted;
  say('mode-text', differs ? `${actual} instead of ${wanted}: ${reason}` : actual);
  chip('chip-mode', actual, differs ? 'warn' : '');
  for (const button of byId('modes').children) {
    button.setAttribute('aria-pressed', String(button.dataset.mode.toUpperCase() === actual));
  }
}

export function showBattery({ part, voltage, current, minutes, temperature }) {
  const charging = current !== null && current > 0;
  const percent = part === null ? 'charge not known' : `${Math.round(part * 100)} %`;
  const left = minutes === null ? ''
    : charging ? `, full in ${span(minutes)}` : `, ${span(minutes)} left`;
  byId('battery-bar').hidden = part === null;
  byId('battery-bar').value = part || 0;
  say('battery-text', `${percent}${left}; ${number(voltage, 2, 'V')}, ${number(current, 2, 'A')}, `
    + number(temperature, 0, '°C'));
  chip('chip-battery', charging ? `${percent} ⚡` : percent,
       part !== null && part < 0.2 ? 'warn' : '');
}

export function showCharger({ state, home_base: base, internal_charger: charger }) {
  const where = base ? ', on the Home Base' : charger ? ', plugged in' : '';
  say('charger-text', `${state}${where}`);
}

export function showDiagnostics(statuses) {
  const link = statuses['serial link'], driver = statuses.driver;
  if (link) {
    const values = link.values;
    say('link-text', `${link.message}: ${values['frames per second']} frames/s, `
      + `${values['damaged frames']} damaged, ${values['silences since start']} silences`);
    byId('link-text').dataset.level = level(link);
  }
  if (driver) {
    say('driver-text', driver.message);
    byId('driver-text').dataset.level = level(driver);
    say('publishers-text', `from ${driver.values['cmd_vel publishers']}`);
  }
  const troubles = Object.entries(statuses)
    .filter(([, status]) => status.level >= WARN)
    .map(([name, status]) => `${name}: ${forPeople(status.message)}`);
  return troubles.join(' · ');
}

function level(status) {
  return status.level >= ERROR ? 'error' : status.level >= WARN ? 'warn' : '';
}

export function showInfrared({ code, name }) {
  say('infrared-text', code === 255 ? 'nothing' : `${code} ${name.replaceAll('_', ' ')}`);
}

export function showPose({ x, y, yaw, speed, turn, covariance }, separation) {
  const half = (turn ?? 0) * separation / 2;
  const [left, right] = [(speed ?? 0) - half, (speed ?? 0) + half].map(each => (100 * each).toFixed(0));
  say('wheels-text', `left ${left} cm/s, right ${right} cm/s`);
  const sigma = covariance[0] === null ? '' : ` ± ${(200 * Math.sqrt(
    Math.max(covariance[0], covariance[2]))).toFixed(0)} cm`;
  say('place-text', `x ${x.toFixed(2)} m, y ${y.toFixed(2)} m${sigma}, `
    + `${Math.round(yaw * 180 / Math.PI)}°`);
  say('speed', `${(speed ?? 0).toFixed(2)} m/s`);
  byId('speed').title = `${(turn ?? 0).toFixed(2)} rad/s`;
}

export function showSeat({ driver, viewers }, you) {
  const mine = driver === you, free = driver === null;
  const others = viewers > 1 ? `, ${viewers} pages open` : '';
  chip('chip-seat', mine ? `you drive${others}` : free ? `nobody drives${others}`
    : `another page drives${others}`, mine || free ? '' : 'warn');
  byId('leave').hidden = !mine || viewers < 2;
  document.body.classList.toggle('watching', !mine && !free);
}

// What is wrong with connection or driver, in a sentence; the chip says it in a word.
export function showConnection(link, { silent, driver_found: found, pose }) {
  const quiet = Math.floor(link.quiet);
  const text = !link.live ? (quiet ? `no news for ${quiet} s` : 'no connection')
    : !found ? 'no driver' : silent ? 'driver silent' : '';
  const trip = link.roundTrip === null ? '' : `, ${Math.round(link.roundTrip)} ms`;
  chip('chip-link', text || `live${trip}`, text ? 'error' : 'good');
  document.body.classList.toggle('dead', text !== '');
  return link.trouble || (!link.live ? 'The connection is lost; trying again.'
    : !pose ? 'Waiting for the robot.'
      : !found ? 'No driver listens to cmd_vel. Is create_node running, in this ROS domain and namespace?'
        : silent ? 'The driver sends nothing. Does the robot answer?' : '');
}

// Dim what shows the parts that are old for their topic.
export function showOld(parts) {
  for (const element of document.querySelectorAll('[data-part]')) {
    element.classList.toggle('old', element.dataset.part.split(' ').some(part => parts.includes(part)));
  }
}

export function showWhy(why, act) {
  byId('why').hidden = !why;
  if (!why) return;
  const [text, name, ...message] = why;
  say('why-text', text);
  byId('why-button').hidden = !name;
  say('why-button', name || '');
  byId('why-button').onclick = () => act(...message);
}

// What happened: [the server's time, '', warn or error, text]; `now` is the server's time.
export function addToLog(entries, now) {
  for (const [at, level, text] of entries) {
    const item = element(byId('log-list'), 'li');
    const time = new Date(Date.now() - 1000 * (now - at)).toLocaleTimeString();
    element(item, 'time', { textContent: time });
    element(item, 'span', { textContent: `${level ? '▲ ' : ''}${forPeople(text)}` })
      .dataset.level = level;
    byId('log-list').prepend(item);
  }
  while (byId('log-list').children.length > MOST_LOGGED) byId('log-list').lastChild.remove();
}

export function showRecording({ state, folder }) {
  const on = state === 'on', failed = state === 'failed';
  say('record', on ? '■ End the recording' : '● Record');
  byId('record').disabled = state === 'ending';
  byId('record').setAttribute('aria-pressed', String(on));
  say('record-text', { on: `Records to ${folder}`, ending: 'Its report is being made.',
                       reported: folder, failed: `The recording failed: see the terminal of create_web.` }[state] || '');
  byId('record-text').dataset.level = failed ? 'error' : '';
  byId('report').hidden = state !== 'reported';
}

// The driver's words are for programs: say what a person can press, and leave out what only a
// program can do.
const FOR_PEOPLE = [
  [/^[a-z]+(_[a-z]+)+: /, ''],  // the name of a message
  [/(call )?set_mode with SAFE( first)?/g, 'press Safe'],
  [/call (stop_demo|stop)\b/g, 'press STOP'],
  [/send the goal undock, it is on its dock.*/, 'it is on its dock, press Leave the dock'],
  [/cancel (it|its goal)\b/g, 'press Cancel'],
  [/the topic `\w+` says that /g, ''],
  [/[;:,] [^;:,/]*(\w_\w|`).*/, ''],
];

export function forPeople(text) {
  return FOR_PEOPLE.reduce((said, [from, to]) => said.replace(from, to), text);
}

let toastTimer = null;

export function toast(text, ok) {
  const element = byId('toast');
  element.textContent = forPeople(text);
  element.dataset.level = ok ? 'good' : 'error';
  element.hidden = false;
  clearTimeout(toastTimer);
  toastTimer = setTimeout(() => { element.hidden = true; }, ok ? 2500 : 6000);
}
