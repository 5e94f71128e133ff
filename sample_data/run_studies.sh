#!/bin/sh
# Runs the studies of docs/studies.md: sample_data/run_studies.sh [STRUNA [FOLDER]]
# Writes records and a page per scene, then tables (to stdout) and figures. Some two minutes.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
struna=${1:-struna}
out=${2:-out/studies}
mkdir -p "$out"

echo "wire_in_band: identify the bare wire, simulate it in its band"
"$struna" --quiet identify "$here/wire_in_band/study.toml" -o "$out/wire_in_band"
"$struna" --quiet simulate "$here/wire_in_band/scene.toml" --parameters "$out/wire_in_band/identified.toml" \
  -o "$out/wire_in_band/simulated.csv" --against "$here/wire_in_band/in_band.csv" --report "$out/wire_in_band.html"
for record in "$here/wire_in_band/in_band.csv" "$out/wire_in_band/simulated.csv"; do
  "$struna" --quiet frf "$record" --input displacement --output force_y --band 20:900 --resolution 4 --estimator h1 \
    -o "$out/wire_in_band/$(basename "$record" .csv)_trfam.csv"
done
"$struna" compare "$out/wire_in_band/in_band_trfam.csv" "$out/wire_in_band/simulated_trfam.csv" \
  -o "$out/wire_in_band/in_band_comparison.csv"

for scene in "$here"/paper_gap/*.toml "$here"/paper_filter/*.toml; do
  name=$(basename "$(dirname "$scene")")_$(basename "$scene" .toml)
  echo "$name"
  "$struna" --quiet simulate "$scene" -o "$out/$name.csv" --report "$out/$name.html"
done
command -v python3 >/dev/null && python3 "$here/../docs/pictures/studies.py" "$out"
