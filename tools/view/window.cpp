#include "tools/view/window.h"

#include <epoxy/gl.h>
// After OpenGL's own names.
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <algorithm>
#include <stdexcept>

#include "host/base/file.h"
#include "host/base/text.h"
#include "tools/view/app.h"

namespace malha::view {

namespace {

std::string glfw_error() {
  const char* what = nullptr;
  glfwGetError(&what);
  return what ? what : "unknown";
}

/// GLFW and its window.
class Display {
 public:
  Display(int width, int height) {
    if (!glfwInit()) throw std::runtime_error("malha view: no window can be opened: " + glfw_error());
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3), glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_SAMPLES, 4);
    window_ = glfwCreateWindow(width, height, "malha", nullptr, nullptr);
    if (!window_) {
      const std::string why = glfw_error();
      glfwTerminate();
      throw std::runtime_error("malha view: OpenGL 3.3 is not there: " + why);
    }
    glfwMakeContextCurrent(window_);
    glfwSwapInterval(1);
  }
  ~Display() {
    glfwDestroyWindow(window_);
    glfwTerminate();
  }
  Display(const Display&) = delete;
  Display& operator=(const Display&) = delete;
  GLFWwindow* window() const { return window_; }

 private:
  GLFWwindow* window_ = nullptr;
};

/// Dear ImGui in that window.
class Gui {
 public:
  explicit Gui(GLFWwindow* window, float scale) {
    ImGui::CreateContext();
    ImGui::GetIO().IniFilename = nullptr;  // no file is left behind
    ImGui::StyleColorsDark();
    ImGui::GetIO().FontGlobalScale = scale;
    ImGui::GetStyle().ScaleAllSizes(scale);
    ImGui_ImplGlfw_InitForOpenGL(window, true);
    ImGui_ImplOpenGL3_Init("#version 330 core");
  }
  ~Gui() {
    ImGui_ImplOpenGL3_Shutdown();
    ImGui_ImplGlfw_Shutdown();
    ImGui::DestroyContext();
  }
  Gui(const Gui&) = delete;
  Gui& operator=(const Gui&) = delete;
};

/// A driver that draws on the CPU keeps one core: threads that wait for each other stand still without it.
WindowOptions for_solver(WindowOptions options, bool in_software) {
  if (in_software && options.simulation.threads == 0) options.simulation.threads = std::max(1, available_threads() - 1);
  return options;
}

}  // namespace

void show_window(const WindowOptions& options) {
  for (const std::string& scene : options.scenes) load_scene(scene);  // refused before a window opens
  const Display display(options.width, options.height);
  GLFWwindow* window = display.window();
  // A driver that draws on the CPU takes it from the solver: half the time at most, and less of very many triangles.
  const std::string renderer = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  const bool in_software = renderer.find("llvmpipe") != std::string::npos;
  float scale = 1;
  glfwGetWindowContentScale(window, &scale, nullptr);
  App app(for_solver(options, in_software), in_software, scale);
  glfwSetWindowUserPointer(window, &app);
  glfwSetDropCallback(window, [](GLFWwindow* of, int count, const char** paths) {
    if (count > 0) static_cast<App*>(glfwGetWindowUserPointer(of))->drop(paths[0]);
  });
  // Dear ImGui 1.86 loses a key that goes down and up within one frame; it passes on to those who were here before.
  glfwSetKeyCallback(window, [](GLFWwindow* of, int key, int, int action, int held) {
    if (action != GLFW_RELEASE) static_cast<App*>(glfwGetWindowUserPointer(of))->key(key, held);
  });
  const Gui gui(window, scale);
  double took = 0;
  while (!glfwWindowShouldClose(window) && !app.quits()) {
    glfwWaitEventsTimeout(app.rests() ? 0.25 : std::max(1.0 / 60 - took, in_software && app.runs() ? took : 1e-3));
    const double start = glfwGetTime();
    ImGui_ImplOpenGL3_NewFrame();
    ImGui_ImplGlfw_NewFrame();
    ImGui::NewFrame();
    int width = 0, height = 0;
    glfwGetFramebufferSize(window, &width, &height);
    app.frame(std::max(width, 1), std::max(height, 1));
    glfwSetWindowTitle(window, app.title().c_str());
    ImGui::Render();
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
    app.drawn(std::max(width, 1), std::max(height, 1));
    glfwSwapBuffers(window);
    took = glfwGetTime() - start;
  }
}

}  // namespace malha::view
