#!/bin/sh
# functions.sh SOURCE_DIR: every function of the shading headers is called in a row of tests/shading/cases/cases_*.h. Prints those
# that are not; exit 1 if any.
set -u
cd "$1" || exit 1
# Comments call nothing.
called=$(cat tests/shading/cases/cases_*.h | sed 's|//.*||; s|/\*.*\*/||g; /^[[:space:]]*\/\*/,/\*\//d' | grep -o 'shade_[a-z0-9_]*(' | sort -u)

# functions HEADER...: "HEADER FUNCTION(" for each.
functions() {
	grep -HE '^SHADE_FN ' "$@" | sed -n 's/^\([^:]*\):SHADE_FN [a-z0-9_]* \(shade_[a-z0-9_]*(\).*/\1 \2/p'
}

without_row() {
	functions "$@" | awk -v called="$called" '
		BEGIN { split(called, names, "\n"); for (i in names) stands[names[i]] = 1 }
		!($2 in stands) { print $1 ": " $2 ") stands in no row of tests/shading/cases/cases_*.h" }'
}

if [ "$(without_row tests/shading/mutation/planted/shade_planted.h | wc -l)" != 3 ]; then
	echo "functions.sh: the three functions of shade_planted.h stand in no row, and were not found"
	exit 1
fi
missing=$(without_row engine/shading/shade_*.h)
[ -z "$missing" ] || { printf '%s\n' "$missing"; exit 1; }
echo "$(functions engine/shading/shade_*.h | wc -l) functions stand in rows"
