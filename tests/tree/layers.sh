#!/usr/bin/env bash
# layers.sh [ROOT]: checks every #include of the tree against layers.txt. Prints one line per violation; exit 1 if any.
# Generated headers, which are not in the tree, must be included by name alone; they belong to the module that includes
# them.
set -euo pipefail
export LC_ALL=C
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
cd "${1:-$here/../..}"

# Prints FILE:LINE:HEADER for every #include, with the quotes or brackets around the header.
includes() {
	"$here/files.sh" "$PWD" | grep -E '\.([ch]|cpp|hpp|cc|glsl|vert|frag|comp)$' |
		xargs -d '\n' grep -nE '^[[:space:]]*#[[:space:]]*include' /dev/null |
		sed -E 's|^([^:]*:[0-9]+:)[[:space:]]*#[[:space:]]*include[[:space:]]*|\1|; s|(["<][^">]*[">]).*|\1|'
}

{ cat "$here/layers.txt"; "$here/files.sh" "$PWD" | sed 's/^/header /'; includes; } | awk '
function bad(message) { print where ": " message; violations++ }
# pattern may have a * at its start or its end
function matches(name, pattern,   n) {
	n = length(pattern)
	if (pattern == "*") return 1
	if (substr(pattern, n) == "*") return index(name, substr(pattern, 1, n - 1)) == 1
	if (substr(pattern, 1, 1) == "*") return length(name) >= n - 1 && substr(name, length(name) - n + 2) == substr(pattern, 2)
	return name == pattern
}
function module_of(path,   r, best) {
	for (r in folder)
		if (index(path, folder[r] "/") == 1 && (best == "" || length(folder[r]) > length(folder[best]))) best = r
	return best
}
function inside(path, folders,   list, n, i) {
	n = split(folders, list, " ")
	for (i = 1; i <= n; i++) if (index(path, list[i] "/") == 1) return 1
	return 0
}
# a/../b is b
function normal(path) {
	gsub(/\/\.\//, "/", path); sub(/^\.\//, "", path)
	while (sub(/[^\/]+\/\.\.\//, "", path)) {}
	return path
}
# The path of a quoted header: looked for in the folder of the file, then in the include paths in the order of the build.
function resolve(file, name,   dir, list, n, i, path) {
	dir = file; if (!sub(/\/[^\/]*$/, "/", dir)) dir = ""
	n = split(dir "|" "|engine/|tests/", list, "|")
	for (i = 1; i <= n; i++) {
		path = normal(list[i] name)
		if (path in exists) return path
	}
	return ""
}
function check_own(file, name,   from, to, path) {
	# Only shaders may use relative paths: glslc resolves them against the including file.
	if (name ~ /(^|\/)\.\.?\// && file ~ /\.([ch]|cpp|hpp|cc)$/) bad("\"" name "\": name headers from the top, not by . or ..")
	from = module_of(file)
	path = resolve(file, name)
	if (path == "") {
		if (name ~ /\//) bad("\"" name "\" is not in the tree")
		return
	}
	to = module_of(path)
	if (to == from || may[from] ~ /\*/) return
	if (index(" " may[from] " ", " " to "+ ")) return
	if (index(" " may[from] " ", " " to " ") == 0) bad(from " may not include " to " (\"" name "\")")
	else if (to in public ? index(public[to] " ", " " path " ") == 0 : path ~ /_internal\.h$/) bad("\"" name "\" is internal to " to)
}
function check_other(file, name,   i) {
	if (module_of(file) == "tests" || module_of(file) == "bench") return
	for (i = 1; i <= libraries; i++)
		if (matches(name, library[i])) {
			if (!inside(file, home[i])) bad("<" name "> belongs to " home[i] " alone")
			return
		}
	for (i = 1; i <= systems; i++) if (matches(name, system_header[i])) return
	if (name !~ /[.\/]/ && file ~ /\.(cpp|hpp|cc)$/) return # the C++ library
	bad("<" name "> is neither a system header nor a library that layers.txt knows")
}
/^#/ || NF == 0 { next }
$1 == "module" {
	folder[$2] = $3; may[$2] = ""
	for (i = 4; i <= NF; i++) may[$2] = may[$2] " " $i
	next
}
$1 == "public" { for (i = 3; i <= NF; i++) public[$2] = public[$2] " " $i; next }
$1 == "library" { library[++libraries] = $2; home[libraries] = $3; for (i = 4; i <= NF; i++) home[libraries] = home[libraries] " " $i; next }
$1 == "system" { for (i = 2; i <= NF; i++) system_header[++systems] = $i; next }
$1 == "header" { exists[substr($0, 8)] = 1; next }
{
	split($0, part, ":")
	file = part[1]; where = part[1] ":" part[2]
	name = substr($0, length(where) + 2)
	seen++
	if (module_of(file) == "") bad("layers.txt assigns this folder to no module")
	else if (name ~ /^".*"$/) check_own(file, substr(name, 2, length(name) - 2))
	else if (name ~ /^<.*>$/) check_other(file, substr(name, 2, length(name) - 2))
	else bad("an include must name its header: " name)
}
END {
	if (!seen) { print "layers.sh: found no include at all"; exit 1 }
	if (violations) { print violations " of " seen " includes break the layers"; exit 1 }
	print seen " includes keep to the layers"
}'
