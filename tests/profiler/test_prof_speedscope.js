// Opens a trace in speedscope, in a headless Chromium, and prints what speedscope made of it:
//   profile NAME            for each thread
//   O|C MICROSECONDS NAME   where a zone opens and closes, since the thread's first
// usage: node test_prof_speedscope.js MODULES CHROMIUM TRACE FOLDER
// MODULES: a node_modules folder with speedscope and puppeteer-core. FOLDER: scratch.
"use strict";
const fs = require("fs"), path = require("path"), url = require("url");
const [modules, chromium, trace, folder] = process.argv.slice(2);
const puppeteer = require(path.join(modules, "puppeteer-core"));

// speedscope loads what a script of this form hands to it, and its "export" (Ctrl+S) saves all profiles as JSON.
async function exported(page, client) {
	const script = path.join(folder, "speedscope_load.js");
	const page_path = path.join(modules, "speedscope/dist/release/index.html");
	const saved = path.join(folder, path.basename(trace, ".json") + ".speedscope.json");
	fs.writeFileSync(script, `speedscope.loadFileFromBase64(${JSON.stringify(path.basename(trace))}, "${
		fs.readFileSync(trace).toString("base64")}")`);
	await client.send("Browser.setDownloadBehavior", {behavior: "allow", downloadPath: folder, eventsEnabled: true});
	const done = new Promise(resolve => client.on("Browser.downloadProgress", e => e.state === "completed" && resolve()));
	await page.goto(url.pathToFileURL(page_path).href + "#localProfilePath=" + script);
	await page.waitForFunction(`document.title.startsWith(${JSON.stringify(path.basename(trace))})`, {timeout: 60000});
	await page.keyboard.down("Control");
	await page.keyboard.press("KeyS");
	await page.keyboard.up("Control");
	await done;
	return JSON.parse(fs.readFileSync(saved));
}

async function main() {
	const browser = await puppeteer.launch({executablePath: chromium, headless: "shell",
		args: ["--no-sandbox", "--allow-file-access-from-files"]});
	try {
		const page = await browser.newPage();
		const file = await exported(page, await browser.target().createCDPSession());
		for (const profile of file.profiles) {
			console.log(`profile ${profile.name}`);
			for (const event of profile.events)
				console.log(`${event.type} ${event.at} ${file.shared.frames[event.frame].name}`);
		}
	} finally {
		await browser.close();
	}
}

main().catch(error => { console.error(error); process.exit(1); });
