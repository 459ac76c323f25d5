// Leaves everything as it is.
Surface surface_function(Surface surface, SurfacePoint point)
{
	return surface;
}
