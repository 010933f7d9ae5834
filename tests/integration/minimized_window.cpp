/// Preload it to make the window minimized: an X server without a window manager cannot minimize.
struct GLFWwindow;
extern "C" void glfwGetFramebufferSize(GLFWwindow* /*window*/, int* width_px, int* height_px);

void glfwGetFramebufferSize(GLFWwindow* /*window*/, int* width_px, int* height_px) {
  *width_px = *height_px = 0;
}
