// Copyright 2026 create_oi_ros contributors
// SPDX-License-Identifier: Apache-2.0
// Elements of a page.

export const byId = id => document.getElementById(id);

// Add an element with these properties to another one.
export function element(parent, name, properties = {}) {
  const made = Object.assign(document.createElement(name), properties);
  parent.append(made);
  return made;
}
