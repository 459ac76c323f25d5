// One scene drawn by three.js in a headless Chromium and by `stilb view`, in turns: CPU time of a frame of each.
// usage: node three.js lights|cascades|post [--lights N] [--range METRES] [--size WxH] [--frames N] [--rounds N]
//        [--stilb FILE] [--picture FILE.png] [-- FLAGS OF STILB]
// lights: N point lights (32) over 225 spheres, each as far as its range (7; 0: without an end).
// cascades: a sun over them, with three.js' CSM, 3 cascades of 1024.
// post: the same sun, without shadows, and three.js' composer: temporal antialiasing, ambient occlusion, bloom, tone.
// For post Stilb takes part if flags for it are given, since they say what it is to draw.
// STILB_NODE_MODULES: a node_modules folder, made by `npm install three puppeteer-core`. STILB_CHROMIUM: the browser,
// else chromium-headless-shell or chromium (Debian). Chromium draws by llvmpipe, the rasteriser of lavapipe, which
// needs Debian's libegl1 and libgl1-mesa-dri. Without these this program ends with 77 and one line.
"use strict";
const child = require("child_process"), fs = require("fs"), http = require("http"), os = require("os");
const path = require("path");

const SIDE = 15, SPACING = 2, RADIUS = 0.8, SEGMENTS = 24, RINGS = 16; // spheres, metres
const AMBIENT = 0.15; // radiance of the surroundings in mode post
const WARM_UP = 10; // frames before those that are measured

function skip(line) {
	console.error(`skipped: ${line}`);
	process.exit(77);
}

function refuse(line) {
	console.error(line);
	process.exit(2);
}

function arguments_of(words) {
	const options = {mode: words[0], lights: 32, range: 7, size: "640x360", frames: 60, rounds: 5,
		stilb: path.join(__dirname, "../../build/release/stilb"), picture: null, flags: []};
	if (!["lights", "cascades", "post"].includes(options.mode))
		refuse(`${options.mode ?? "no mode"}: the mode is lights, cascades or post`);
	for (let i = 1; i < words.length; i++) {
		if (words[i] === "--") {
			options.flags = words.slice(i + 1);
			break;
		}
		const name = words[i].replace(/^--/, ""), value = words[++i];
		if (!Object.hasOwn(options, name) || ["mode", "flags"].includes(name) || value === undefined)
			refuse(`${words[i - 1]}: unknown, or without a value; see the head of ${__filename}`);
		const least = {lights: 0, range: 0, frames: 1, rounds: 1}[name];
		if (least !== undefined && !(Number(value) >= least && (name === "range" || Number.isInteger(Number(value)))))
			refuse(`--${name} ${value}: not a number of at least ${least}`);
		options[name] = least === undefined ? value : Number(value);
	}
	const size = /^(\d+)x(\d+)$/.exec(options.size);
	if (!size)
		refuse(`--size ${options.size}: not WIDTHxHEIGHT`);
	[options.width, options.height] = [Number(size[1]), Number(size[2])];
	return options;
}

// ---- the scene, a glTF file ----

function sphere() {
	const points = [], triangles = [];
	for (let ring = 0; ring <= RINGS; ring++)
		for (let segment = 0; segment <= SEGMENTS; segment++) {
			const polar = Math.PI * ring / RINGS, around = 2 * Math.PI * segment / SEGMENTS;
			points.push(Math.sin(polar) * Math.cos(around), Math.cos(polar), -Math.sin(polar) * Math.sin(around));
		}
	for (let ring = 0; ring < RINGS; ring++)
		for (let segment = 0; segment < SEGMENTS; segment++) {
			const a = ring * (SEGMENTS + 1) + segment, b = a + SEGMENTS + 1;
			if (ring > 0)
				triangles.push(a, b, a + 1);
			if (ring < RINGS - 1)
				triangles.push(b, b + 1, a + 1);
		}
	return {points: points.map(x => RADIUS * x), normals: points, triangles};
}

function floor() {
	const half = SIDE * SPACING / 2 + 1;
	return {points: [-half, 0, -half, -half, 0, half, half, 0, half, half, 0, -half],
		normals: [0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0], triangles: [0, 1, 2, 0, 2, 3]};
}

// A colour of full saturation; hue in [0, 1).
function hue(h) {
	return [0, 1 / 3, 2 / 3].map(shift => Math.min(Math.max(Math.abs(((h + 1 - shift) % 1) * 6 - 3) - 1, 0), 1));
}

// A fraction in [0, 1) that looks random, the same in every run.
function scattered(i) {
	return i * 0.6180339887498949 % 1;
}

function write_scene(file, options) {
	const gltf = {asset: {version: "2.0"}, scene: 0, scenes: [{nodes: []}], nodes: [], meshes: [], materials: [],
		accessors: [], bufferViews: [], buffers: [], cameras: [{type: "perspective", perspective:
			{yfov: 0.8, aspectRatio: options.width / options.height, znear: 0.5, zfar: 80}}]};
	const bytes = [];
	let length = 0;
	const accessor = (array, type, rest) => {
		const buffer = Buffer.from(array.buffer);
		gltf.bufferViews.push({buffer: 0, byteOffset: length, byteLength: buffer.length});
		gltf.accessors.push({bufferView: gltf.bufferViews.length - 1, type,
			componentType: array instanceof Float32Array ? 5126 : 5125,
			count: array.length / (type === "VEC3" ? 3 : 1), ...rest});
		bytes.push(buffer);
		length += buffer.length;
		return gltf.accessors.length - 1;
	};
	const add_shape = shape => {
		const axis = (a, pick) => pick(...shape.points.filter((x, i) => i % 3 === a).map(Math.fround));
		return {attributes: {
			POSITION: accessor(new Float32Array(shape.points), "VEC3",
				{min: [0, 1, 2].map(a => axis(a, Math.min)), max: [0, 1, 2].map(a => axis(a, Math.max))}),
			NORMAL: accessor(new Float32Array(shape.normals), "VEC3")},
			indices: accessor(new Uint32Array(shape.triangles), "SCALAR")};
	};
	const add_mesh = (shape, color, roughness) => {
		gltf.materials.push({pbrMetallicRoughness: {baseColorFactor: [...color, 1], roughnessFactor: roughness,
			metallicFactor: 0}});
		gltf.meshes.push({primitives: [{...shape, material: gltf.materials.length - 1}]});
		return gltf.meshes.length - 1;
	};
	const add_node = node => gltf.scenes[0].nodes.push(gltf.nodes.push(node) - 1);

	add_node({mesh: add_mesh(add_shape(floor()), [0.5, 0.5, 0.5], 0.8)});
	const ball = add_shape(sphere());
	const middle = (SIDE - 1) / 2;
	for (let row = 0; row < SIDE; row++) {
		const color = hue(row / SIDE).map(c => 0.3 + 0.6 * c);
		const mesh = add_mesh(ball, color, 0.25 + 0.6 * row / (SIDE - 1));
		for (let column = 0; column < SIDE; column++)
			add_node({mesh, translation: [(column - middle) * SPACING, RADIUS, (row - middle) * SPACING]});
	}
	const down = 0.5; // the camera looks down by as many radians
	add_node({camera: 0, translation: [0, 14, 24], rotation: [-Math.sin(down / 2), 0, 0, Math.cos(down / 2)]});

	const lights = [];
	if (options.mode === "lights")
		for (let i = 0; i < options.lights; i++) {
			const half = SIDE * SPACING / 2;
			const color = hue(scattered(3 * i)).map(c => 0.25 + 0.75 * c);
			lights.push(options.range > 0 ? {type: "point", intensity: 6, color, range: options.range}
				: {type: "point", intensity: 2, color});
			add_node({extensions: {KHR_lights_punctual: {light: i}}, translation: [
				half * (2 * (i + 0.5) / options.lights - 1), 2 + scattered(5 * i), half * (2 * scattered(i) - 1)]});
		}
	else {
		lights.push({type: "directional", intensity: 2.5, color: [1, 1, 1]});
		const tilt = -0.9; // about x, from the direction -z towards the ground
		add_node({extensions: {KHR_lights_punctual: {light: 0}}, rotation: [
			Math.cos(0.35) * Math.sin(tilt / 2), Math.sin(0.35) * Math.cos(tilt / 2),
			-Math.sin(0.35) * Math.sin(tilt / 2), Math.cos(0.35) * Math.cos(tilt / 2)]});
	}
	if (lights.length > 0) {
		gltf.extensionsUsed = ["KHR_lights_punctual"];
		gltf.extensions = {KHR_lights_punctual: {lights}};
	}
	gltf.buffers.push({byteLength: length,
		uri: "data:application/octet-stream;base64," + Buffer.concat(bytes).toString("base64")});
	fs.writeFileSync(file, JSON.stringify(gltf));
}

// ---- three.js ----

// The page, three.js and the scene, for the browser; nothing else is served.
function serve(modules, scene) {
	const three = path.join(modules, "three") + path.sep;
	const types = {".html": "text/html", ".js": "text/javascript", ".gltf": "model/gltf+json"};
	const server = http.createServer((request, response) => {
		const name = decodeURIComponent(new URL(request.url, "http://localhost").pathname);
		const file = name === "/" ? path.join(__dirname, "three.html") : name === "/scene.gltf" ? scene
			: path.normalize(path.join(modules, name));
		if (file !== scene && name !== "/" && !file.startsWith(three) || !fs.existsSync(file)) {
			response.writeHead(404).end();
			return;
		}
		response.writeHead(200, {"Content-Type": types[path.extname(file)] ?? "application/octet-stream"});
		fs.createReadStream(file).pipe(response);
	});
	return new Promise(resolve => server.listen(0, "127.0.0.1", () => resolve(server)));
}

// CPU time, in ms, that a process and all below it have used (proc(5): parent, user, system, of all threads).
function cpu_of_tree(root) {
	const processes = new Map();
	for (const name of fs.readdirSync("/proc").filter(name => /^\d+$/.test(name))) {
		try {
			const fields = fs.readFileSync(`/proc/${name}/stat`, "utf8").replace(/^.*\) /s, "").split(" ");
			processes.set(Number(name), {parent: Number(fields[1]), ticks: Number(fields[11]) + Number(fields[12])});
		} catch {} // it has ended
	}
	const below = id => id === root || processes.has(id) && below(processes.get(id).parent);
	let ticks = 0;
	for (const [id, one] of processes)
		if (below(id))
			ticks += one.ticks;
	return ticks * 1000 / ticks_per_second;
}
const ticks_per_second = Number(child.execFileSync("getconf", ["CLK_TCK"]));

async function open_three(setup, options) {
	const browser = await setup.puppeteer.launch({executablePath: setup.chromium, headless: "shell",
		args: ["--no-sandbox", "--use-gl=angle", "--use-angle=gl-egl", "--ignore-gpu-blocklist"],
		protocolTimeout: 600000});
	const page = await browser.newPage();
	await page.setViewport({width: options.width, height: options.height});
	page.on("console", message => ["error", "warn"].includes(message.type()) &&
		console.error(`three.js: ${message.text()}`));
	const query = new URLSearchParams({mode: options.mode, width: options.width, height: options.height,
		ambient: AMBIENT});
	await page.goto(`http://127.0.0.1:${setup.server.address().port}/?${query}`);
	await page.waitForFunction("window.peer || window.failure", {timeout: 60000});
	const failure = await page.evaluate("window.failure");
	if (failure)
		throw new Error(failure);
	await page.evaluate(`peer.frames(${WARM_UP})`);
	return {browser, page};
}

async function measure_three(setup, options) {
	const {browser, page} = await open_three(setup, options);
	try {
		const before = cpu_of_tree(browser.process().pid);
		await page.evaluate(`peer.frames(${options.frames})`);
		return (cpu_of_tree(browser.process().pid) - before) / options.frames;
	} finally {
		await browser.close();
	}
}

// ---- Stilb ----

function stilb(setup, options, frames, more) {
	const light = {
		lights: ["--ambient", "none", "--tone", "none", "--shadows", "off"],
		cascades: ["--ambient", "none", "--tone", "none", "--shadows", "map", "--cascades", "3", "--cascade-size", "1024"],
		post: ["--environment", [AMBIENT, AMBIENT, AMBIENT].join(","), "--shadows", "off"],
	}[options.mode];
	const flags = ["view", setup.scene, "--headless", "--size", options.size, "--frames", String(frames),
		"--exposure", "0", "--background", "0,0,0", "--studio", "off", "--msaa", "1", "--lod", "off", ...light,
		...options.flags, ...more];
	// The shell's `time` counts all threads of the program.
	const script = "TIMEFORMAT='cpu %3U %3S'; time \"$@\" >/dev/null";
	const run = child.spawnSync("bash", ["-c", script, "bash", options.stilb, ...flags], {encoding: "utf8"});
	const times = /^cpu (\S+) (\S+)$/m.exec(run.stderr);
	if (run.status !== 0 || !times)
		throw new Error(`${options.stilb} ${flags.join(" ")}: ${run.stderr}`);
	return (Number(times[1]) + Number(times[2])) * 1000;
}

// A run of more frames less one of fewer: what the start costs is in both.
function measure_stilb(setup, options) {
	const fewer = stilb(setup, options, WARM_UP, []);
	return (stilb(setup, options, WARM_UP + options.frames, []) - fewer) / options.frames;
}

// ---- the comparison ----

function median(values) {
	const sorted = [...values].sort((a, b) => a - b), half = sorted.length >> 1;
	return sorted.length % 2 ? sorted[half] : (sorted[half - 1] + sorted[half]) / 2;
}

function line(name, values, unit, digits) {
	const text = x => x.toFixed(digits);
	console.log(`${name.padEnd(20)} ${text(median(values))} ${unit} `
		+ `[${text(Math.min(...values))}-${text(Math.max(...values))}]`);
}

function find_setup() {
	const modules = process.env.STILB_NODE_MODULES;
	for (const name of ["three", "puppeteer-core"])
		if (!modules || !fs.existsSync(path.join(modules, name)))
			skip(`no ${name} in STILB_NODE_MODULES (${modules ?? "not set"}); npm install three puppeteer-core`);
	const chromium = process.env.STILB_CHROMIUM ?? ["chromium-headless-shell", "chromium"].flatMap(name =>
		process.env.PATH.split(":").map(folder => path.join(folder, name))).find(file => fs.existsSync(file));
	if (!chromium || !fs.existsSync(chromium))
		skip("no Chromium; apt-get install chromium-headless-shell libegl1 libgl1-mesa-dri, or set STILB_CHROMIUM");
	return {modules: path.resolve(modules), chromium, puppeteer: require(path.resolve(modules, "puppeteer-core"))};
}

async function show(setup, options, both) {
	const {browser, page} = await open_three(setup, options);
	try {
		const facts = await page.evaluate("peer.facts()");
		console.log(`three.js r${facts.revision} on ${facts.device}: ${facts.calls} draws, `
			+ `${facts.triangles} triangles a frame`);
		if (facts.error !== 0)
			throw new Error(`WebGL reports error ${facts.error}`);
		if (!/llvmpipe/.test(facts.device))
			console.log("which is not llvmpipe, the rasteriser of lavapipe: the ratio compares rasterisers, too");
		let png = null;
		if (both) {
			const ours = path.join(setup.folder, "stilb.png");
			stilb(setup, options, 1, ["--screenshot", ours]);
			const url = "data:image/png;base64," + fs.readFileSync(ours).toString("base64");
			const seen = await page.evaluate(other => peer.beside(other), url);
			console.log(`pictures differ by ${seen.rms.toFixed(2)} of 255 steps (root mean square); `
				+ `${(100 * seen.over).toFixed(2)} % of the pixels by more than 8`);
			png = seen.png;
		} else if (options.picture) {
			png = await page.evaluate("document.querySelector('canvas').toDataURL('image/png')");
		}
		if (options.picture)
			fs.writeFileSync(options.picture, Buffer.from(png.split(",")[1], "base64"));
	} finally {
		await browser.close();
	}
}

async function main() {
	const options = arguments_of(process.argv.slice(2)), setup = find_setup();
	const both = options.mode !== "post" || options.flags.length > 0;
	if (both && !fs.existsSync(options.stilb))
		refuse(`${options.stilb}: not there; build it, or name another with --stilb`);
	setup.folder = fs.mkdtempSync(path.join(os.tmpdir(), "stilb-three-"));
	setup.scene = path.join(setup.folder, "scene.gltf");
	try {
		write_scene(setup.scene, options);
		setup.server = await serve(setup.modules, setup.scene);
		await show(setup, options, both);
		const theirs = [], ours = [];
		for (let round = 0; round < options.rounds; round++) {
			theirs.push(await measure_three(setup, options));
			if (both)
				ours.push(measure_stilb(setup, options));
		}
		console.log(`CPU time a frame of ${options.size} pixels, medians of ${options.rounds} rounds [least-most], `
			+ `load ${os.loadavg()[0].toFixed(1)} on ${os.cpus().length} CPUs:`);
		line("three.js", theirs, "ms", 1);
		if (both) {
			line("Stilb", ours, "ms", 1);
			line("Stilb / three.js", ours.map((ms, i) => ms / theirs[i]), "x", 3);
		}
	} finally {
		setup.server?.close();
		fs.rmSync(setup.folder, {recursive: true});
	}
}

main().catch(error => { console.error(error.message); process.exit(1); });
