# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
"""
`create_web`: a live page that shows a robot in a browser, and drives it.

`create_web` is the program. `web_server` answers browsers, `viewers` holds their connections and
the ROS node, and follows goals to their end. `access` (who may see the page, what it may send, and
who drives) and `live_robot` (what a page is sent) are pure. `simulated_truth` asks a simulated
robot where it really is. `page/` is what a browser loads.
"""
