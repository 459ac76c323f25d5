#!/bin/bash
# layers.sh STILB LAYERS_MADE OUT.png: makes docs/gi/layers.png: balls of every layer, written by the tests' program
# layers_made, by `stilb render`.
set -eu
[ $# = 3 ] || { sed -n '2,3s/^# \{0,1\}//p' "$0"; exit 2; }
folder=$(mktemp -d)
trap 'rm -r "$folder"' EXIT
"$2" "$folder/layers.glb"
"$1" render "$folder/layers.glb" --quiet --size 640x400 --spp 256 --environment 0.35,0.4,0.5 -o "$3"
