// Keeps libraries loaded until the process ends, in builds with sanitizers: what a driver or layer holds in its own variables is no leak while
// it is there, and a leak's stack has no names once it is gone. The Vulkan loader calls this one, as the program's symbols come first.
extern "C" int dlclose(void*) { return 0; }
