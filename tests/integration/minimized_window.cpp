/// Library to preload, which makes the window minimized. An X server without a window manager cannot minimize
/// windows.
struct GLFWwindow;
extern "C" void glfwGetFramebufferSize(GLFWwindow* /*window*/, int* width_px, int* height_px);

void glfwGetFramebufferSize(GLFWwindow* /*window*/, int* width_px, int* height_px) {
  *width_px = *height_px = 0;
}
