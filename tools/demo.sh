#!/usr/bin/env bash
# Copyright 2026 create_oi_ros contributors
# SPDX-License-Identifier: Apache-2.0
#
# A simulated robot drives examples/tour.py in three minutes, recorded and reported on: make demo
set -eu
folder=demo-$(date +%Y%m%d-%H%M%S)
# A domain that this computer alone hears: nobody else's robot drives the tour.
export ROS_DOMAIN_ID=214 ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST
trap 'trap - EXIT; kill $(jobs -p) 2> /dev/null || true; wait' EXIT
mkdir "$folder"
create_record -o "$folder/bag" &
recorder=$!
create_run --world apartment &
code=0
python "$(dirname "$0")/../examples/tour.py" || code=$?
kill $recorder
wait $recorder
create_report "$folder/bag" -o "$folder/report.html"
exit $code
