/// Preloaded, it makes a window that is minimized: an X server without a window manager has no such.
struct GLFWwindow;
extern "C" void glfwGetFramebufferSize(GLFWwindow* /*window*/, int* width_px, int* height_px);

void glfwGetFramebufferSize(GLFWwindow* /*window*/, int* width_px, int* height_px) {
  *width_px = *height_px = 0;
}
