#!/bin/sh
# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
#
# Print the first Python on this machine that can build the project, or what is missing.
# Usage: tools/find_python.sh KIND, where KIND is `wheels` or `jazzy`. PYTHON= selects a Python.
check="$(dirname "$0")/check.py"
unsuitable='no Python 3.11 to 3.13: sudo apt-get install python3 python3-venv python3-dev'
[ -z "$PYTHON" ] || unsuitable="PYTHON=$PYTHON does not run"
lacking=''

candidates='python3 python3.12 python3.13 python3.11 /usr/bin/python3'
[ "$1" = jazzy ] && candidates=/usr/bin/python3  # the one that ROS's own packages are built for

for python in ${PYTHON:-$candidates}; do
    # A name on PATH can be a shim without a Python behind it: only running it shows that.
    complaint=$("$python" "$check" "$1" 2>/dev/null)
    case $? in
        0) echo "$python"; exit 0 ;;
        1) lacking=${lacking:-$complaint} ;;
        2) unsuitable=$complaint ;;
    esac
done
echo "make: ${lacking:-$unsuitable}" >&2
exit 1
