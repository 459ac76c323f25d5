/*
 * A dlclose that keeps the library loaded, linked into every program of an address-sanitizer build.
 * The leak check runs at exit and needs the symbols of whoever allocated: memory that a Vulkan driver still owns after
 * the loader has unloaded it would otherwise be reported as a leak in "<unknown module>".
 */
__attribute__((visibility("default"))) int dlclose(void *library);

int dlclose(void *library)
{
	(void)library;
	return 0;
}
