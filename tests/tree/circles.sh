#!/usr/bin/env bash
# circles.sh BUILD [LIST]: finds object files of one library or program that need each other, directly or through others,
# so that none can be understood or tested without the rest. LIST (circles.txt) names the circles that are right, each
# with its reason; one that no longer exists must be removed. Prints one line per violation; exit 1 if any.
set -euo pipefail
export LC_ALL=C
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
build=$1
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
list=${2:-$here/circles.txt}

# Prints the symbols of all objects as nm does, each line after the name of the module; a line "MODULE OBJECT:" begins an
# object.
symbols() {
	local archive name folder
	find "$build" -name 'libstilb-*.a' | sort | while read -r archive; do
		name=$(basename "$archive" .a)
		nm --extern-only --format=posix "$archive" 2>/dev/null | sed "s|^|${name#libstilb-} |"
	done
	for name in stilb stilb-bench; do
		find "$build" -type d -path "*/CMakeFiles/$name.dir" | while read -r folder; do
			find "$folder" -name '*.o' | sort | while read -r object; do
				# Skips objects that a build folder keeps of sources that were moved or removed.
				source=${folder#"$build"/}
				source=${source%%/CMakeFiles/*}/${object#"$folder"/}
				source=${source//__/..}
				[ -e "$here/../../${source%.o}" ] || continue
				printf '%s %s:\n' "$name" "$(basename "$object")"
				nm --extern-only --format=posix "$object" | sed "s|^|$name |"
			done
		done
	done | cat
}

symbols | awk '
	# "libstilb-x.a[a.c.o]:" or "a.c.o:" starts an object
	NF == 2 && $2 ~ /:$/ { object = $2; sub(/^.*\[/, "", object); sub(/\]?:$/, "", object); sub(/\.o$/, "", object); next }
	NF >= 3 && $3 == "U" { wants[$1, object] = wants[$1, object] " " $2; next }
	NF >= 3 && $3 ~ /^[A-Z]$/ && $3 !~ /[WV]/ { owner[$1, $2] = object; if (!(($1, object) in seen)) { seen[$1, object] = 1; objects[$1] = objects[$1] " " object } }
	END {
		for (module in objects) {
			n = split(objects[module], name, " ")
			for (i = 1; i <= n; i++) number[module, name[i]] = i
			split("", reach)
			for (i = 1; i <= n; i++) {
				m = split(wants[module, name[i]], want, " ")
				for (k = 1; k <= m; k++) {
					to = owner[module, want[k]]
					if (to != "" && to != name[i]) reach[i, number[module, to]] = 1
				}
			}
			for (k = 1; k <= n; k++)
				for (i = 1; i <= n; i++)
					if ((i, k) in reach)
						for (j = 1; j <= n; j++)
							if ((k, j) in reach) reach[i, j] = 1
			split("", done)
			for (i = 1; i <= n; i++) {
				if (i in done || !((i, i) in reach)) continue
				circle = module
				for (j = i; j <= n; j++) if ((i, j) in reach && (j, i) in reach) { circle = circle " " name[j]; done[j] = 1 }
				print circle
			}
		}
	}' | while read -r module members; do
	printf '%s %s\n' "$module" "$(tr ' ' '\n' <<<"$members" | sort | paste -sd ' ')"
done | sort >"$scratch/found"

sed -n 's/^\([a-z][^#]*[^# ]\) *#.*/\1/p' "$list" | while read -r module members; do
	printf '%s %s\n' "$module" "$(tr ' ' '\n' <<<"$members" | sort | paste -sd ' ')"
done | sort >"$scratch/listed"
new=$(comm -23 "$scratch/found" "$scratch/listed")
gone=$(comm -13 "$scratch/found" "$scratch/listed")
[ -z "$new" ] || printf '%s\n' "$new" | sed 's/^\([^ ]*\) /\1: a circle of object files: /'
[ -z "$gone" ] || printf '%s\n' "$gone" | sed 's/^\([^ ]*\) /\1: circles.txt lists a circle that is not there: /'
[ -z "$new$gone" ] || exit 1
echo "$(wc -l <"$scratch/found") circles of object files, all with a reason"
