#!/bin/bash
# lights.sh STILB OUT.png: makes docs/lights.png: the stress test under 230 lamps by each way of lighting, and below it 64
# times what it differs from the first one. STILB is a build with a Vulkan driver. Needs ImageMagick's convert and montage
# (apt install imagemagick).
set -eu
[ $# = 2 ] || { sed -n '2,4s/^# \{0,1\}//p' "$0"; exit 2; }
stilb=$(realpath "$1") out=$2
folder=$(mktemp -d)
trap 'rm -r "$folder"' EXIT
number=0
picture() { # NAME FLAGS...
	local name=$1
	shift
	number=$((number + 1))
	"$stilb" demo --headless --frames 2 --size 320x180 --models 400 --lights 230 --shadows off "$@" --screenshot "$folder/$number.png" >"$folder/said"
	[ $number -gt 1 ] || cp "$folder/1.png" "$folder/first.png"
	convert "$folder/$number.png" "$folder/first.png" -compose difference -composite -evaluate multiply 64 "$folder/off.png"
	convert "$folder/$number.png" "$folder/off.png" -append +repage -background white -fill black \
		\( -size 320x22 -pointsize 13 -gravity center caption:"$name" \) -append "$folder/with-name-$(printf %02d $number).png"
}
picture forward --lighting forward
picture clustered --lighting clustered
picture deferred --lighting deferred
picture 'deferred, rgba8' --lighting deferred --gbuffer rgba8
picture 'deferred, rectangles' --lighting deferred --light-coverage rectangles
picture 'deferred, volumes' --lighting deferred --light-coverage volumes
picture multipass --lighting multipass
picture tiled-deferred --lighting tiled-deferred
picture tiled-forward --lighting tiled-forward
picture indexed --lighting indexed
picture combined --lighting combined
picture prelight --lighting prelight
picture prepass --lighting prepass
montage "$folder"/with-name-*.png -tile 4x -geometry +3+3 -background white -depth 8 -strip -define png:color-type=2 "$out"
