# mutants.awk: a shading header in, the same header out with every float literal k replaced by shade_mutant(ID, k), which
# returns k, or a changed k if the environment says so (mutant.h). A file LIST gets a line "ID PLACE LITERAL" for each.
#     awk -v first=ID -v place=engine/shading/shade_x.h -v list=LIST -f mutants.awk shade_x.h
# Left as they are: 0.0f; clamps and epsilons, that is a bare 1.0f or -1.0f inside min, max or clamp, and macros whose names
# end in _EPSILON, _MIN, _MAX or _LIMIT. A table (SHADE_CONST) is filled when the program starts: calls are no constants.
function at(i) { return substr(text, i, 1) }

# The literal at i, if one begins there.
function literal_at(i,   rest) {
	if (at(i) !~ /[0-9.]/ || (i > 1 && at(i - 1) ~ /[A-Za-z0-9_.]/)) return ""
	rest = substr(text, i, 40)
	return match(rest, /^([0-9]+\.[0-9]*|\.[0-9]+|[0-9]+)([eE][-+]?[0-9]+)?f/) ? substr(rest, 1, RLENGTH) : ""
}

# Is the literal from i to last, with its sign, a whole argument of min, max or clamp?
function is_clamp(i, last,   before, after) {
	if (caller[depth] !~ /^(min|max|clamp)$/) return 0
	for (before = i - 1; at(before) ~ /[- \t\n]/; before--) continue
	for (after = last + 1; at(after) ~ /[ \t\n]/; after++) continue
	return at(before) ~ /[(,]/ && at(after) ~ /[),]/
}

function word_before(i,   end) {
	for (end = i - 1; end > 0 && at(end) == " "; end--) continue
	for (i = end; i > 0 && at(i) ~ /[A-Za-z0-9_]/; i--) continue
	return substr(text, i + 1, end - i)
}

# SHADE_CONST type name[size] = {...}; becomes a variable and a function that fills it before main.
function begin_table(i,   head, name, size) {
	head = substr(text, i, index(substr(text, i), "=") - 1)
	sub(/^SHADE_CONST[ \t\n]+/, "", head)
	sub(/[ \t\n]+$/, "", head)
	size = match(head, /\[.*/) ? substr(head, RSTART) : ""
	sub(/\[.*/, "", head)
	name = head; sub(/.*[ \t\n]/, "", name)
	sub(/[ \t\n]*[A-Za-z0-9_]+$/, "", head)
	printf "static __attribute__((unused)) %s %s%s; ", head, name, size
	printf "static __attribute__((constructor)) void %s_fill(void) { %s value%s ", name, head, size
	table = name
	return i + index(substr(text, i), "=") - 1
}

function end_table() {
	printf "; __builtin_memcpy(&%s, &value, sizeof value); }", table
	table = ""
}

{ text = text $0 "\n" }

END {
	id = first; line = 1; depth = 0; size = length(text)
	for (i = 1; i <= size; i++) {
		c = at(i); two = substr(text, i, 2)
		if (two == "/*" || two == "//") { # copied up to its end
			ending = two == "/*" ? "*/" : "\n"
			span = index(substr(text, i + 2), ending) + 1 + (two == "/*" ? 2 : 0)
			comment = substr(text, i, span)
			printf "%s", comment
			line += gsub(/\n/, "", comment)
			i += span - 1
			continue
		}
		if (c == "\n") {
			line++
			if (at(i - 1) != "\\") macro = ""
		} else if (c == "#" && match(substr(text, i, 200), /^#[ \t]*define[ \t]+[A-Za-z0-9_]+/)) {
			macro = substr(text, i, RLENGTH); sub(/.*[ \t]/, "", macro)
		} else if (c == "(") caller[++depth] = word_before(i)
		else if (c == ")") depth--
		else if (c == ";" && table != "") { end_table(); continue }
		else if (substr(text, i, 12) == "SHADE_CONST " && macro == "") i = begin_table(i)
		literal = literal_at(i)
		if (literal == "") { printf "%s", at(i); continue }
		i += length(literal) - 1
		if (literal + 0 == 0 || macro ~ /_(EPSILON|MIN|MAX|LIMIT)$/ ||
		    (literal + 0 == 1 && is_clamp(i - length(literal) + 1, i))) { printf "%s", literal; continue }
		printf "shade_mutant(%d, %s)", id, literal
		print id, place ":" line, literal >list
		id++
	}
}
