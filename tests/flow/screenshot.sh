#!/bin/sh
# A picture of a report as a browser draws it, for developers: screenshot.sh REPORT.html PICTURE.png [WIDTH [HEIGHT [dark]]]
set -eu
[ $# -ge 2 ] || { sed -n '2s/^# //p' "$0" >&2; exit 2; }
page=$(realpath "$1")
profile=$(mktemp -d)
trap 'rm -rf "$profile"' EXIT
dark=
[ "${5:-}" = dark ] && dark=--blink-settings=preferredColorScheme=0
chromium --headless --no-sandbox --disable-gpu --hide-scrollbars --user-data-dir="$profile" $dark \
  --window-size="${3:-1400},${4:-6000}" --virtual-time-budget=20000 --screenshot="$2" "file://$page" 2>/dev/null
