#!/bin/sh
# shader.sh DONOR OUTPUT.inc COMMAND...: compiles a shader. COMMAND writes OUTPUT.inc, and to OUTPUT.d what it was made from;
# OUTPUT.command keeps the command. DONOR.inc is the same shader in another build. If it was made by the same command and is
# younger than all that it was made from, it is copied instead: the large shaders take a second each, in each build.
set -euf
donor=${1%.inc} output=${2%.inc}
shift 2
said=$(printf '%s ' "$@" | sed "s|$output\.|OUTPUT.|g")

is_sound() { # DONOR has all its files, and none of its sources is as young as it
	[ "$(cat "$donor.command" 2>/dev/null)" = "$said" ] && [ -e "$donor.d" ] || return 1
	for file in $(sed 's/^[^:]*://; s/\\$//' "$donor.d"); do
		[ -e "$file" ] && [ "$file" -ot "$donor.inc" ] || return 1
	done
}

rm -f "$output.command"
if is_sound; then
	cp "$donor.inc" "$output.inc"
	sed "s|^[^:]*:|$output.inc:|" "$donor.d" >"$output.d"
else
	"$@"
fi
printf '%s' "$said" >"$output.command"
