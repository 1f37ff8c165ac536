// SPDX-License-Identifier: Apache-2.0
#include "tools/view/window.h"

#include <epoxy/gl.h>
// GLFW must be included after OpenGL.
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <algorithm>
#include <stdexcept>

#include "host/base/file.h"
#include "malha/text.h"
#include "tools/view/app.h"
#include "tools/view/keys.h"

namespace malha::view {

namespace {

std::string glfw_error() {
  const char* what = nullptr;
  glfwGetError(&what);
  return what ? what : "unknown";
}

/// Owns GLFW and its window.
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

/// Owns Dear ImGui in that window.
class Gui {
 public:
  explicit Gui(GLFWwindow* window, float scale) {
    ImGui::CreateContext();
    ImGui::GetIO().IniFilename = nullptr;  // write no file
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

/// The objects that GLFW's callbacks use.
struct Listener {
  App& app;
  InputQueue keys;
};
Listener& listener_of(GLFWwindow* window) { return *static_cast<Listener*>(glfwGetWindowUserPointer(window)); }

bool is_modifier(int key) { return key >= GLFW_KEY_LEFT_SHIFT && key <= GLFW_KEY_RIGHT_SUPER; }

/// Replaces Dear ImGui's callbacks by ones that queue the events; listen() passes them on.
void keep_keys(GLFWwindow* window) {
  glfwSetKeyCallback(window, [](GLFWwindow* of, int key, int scancode, int action, int held) {
    const Input::Kind kind = is_modifier(key) ? Input::Kind::Modifier : Input::Kind::Key;
    listener_of(of).keys.add({kind, key, action, held, scancode, action == GLFW_PRESS, action == GLFW_REPEAT});
  });
  glfwSetCharCallback(window, [](GLFWwindow* of, unsigned letter) {
    listener_of(of).keys.add({Input::Kind::Letter, int(letter)});
  });
  glfwSetMouseButtonCallback(window, [](GLFWwindow* of, int button, int action, int held) {
    listener_of(of).keys.add({Input::Kind::Button, button, action, held, 0, action == GLFW_PRESS});
  });
}

/// Passes the events of this frame to Dear ImGui and returns them.
std::vector<Input> listen(GLFWwindow* window) {
  const std::vector<Input> inputs = listener_of(window).keys.of_next_frame();
  for (const Input& input : inputs) {
    if (input.kind == Input::Kind::Letter) {
      ImGui_ImplGlfw_CharCallback(window, unsigned(input.code));
    } else if (input.kind == Input::Kind::Button) {
      ImGui_ImplGlfw_MouseButtonCallback(window, input.code, input.action, input.held);
    } else {
      ImGui_ImplGlfw_KeyCallback(window, input.code, input.scancode, input.action, input.held);
    }
  }
  return inputs;
}

/// Leaves one core to a driver that renders on the CPU, because threads that synchronise stall when a core is missing.
WindowOptions for_solver(WindowOptions options, bool in_software) {
  if (in_software && options.simulation.threads == 0) options.simulation.threads = std::max(1, available_threads() - 1);
  return options;
}

}  // namespace

void show_window(const WindowOptions& options) {
  for (const std::string& scene : options.scenes) load_scene(scene);  // a bad scene is refused before a window opens
  const Display display(options.width, options.height);
  GLFWwindow* window = display.window();
  // A driver that renders on the CPU competes with the solver. It gets half the time at most, and bodies with very many
  // triangles are decimated.
  const std::string renderer = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  const bool in_software = renderer.find("llvmpipe") != std::string::npos;
  float scale = 1;
  glfwGetWindowContentScale(window, &scale, nullptr);
  App app(for_solver(options, in_software), in_software, scale);
  Listener listener{app, {}};
  glfwSetWindowUserPointer(window, &listener);
  glfwSetDropCallback(window, [](GLFWwindow* of, int count, const char** paths) {
    if (count > 0) listener_of(of).app.drop(paths[0]);
  });
  const Gui gui(window, scale);
  keep_keys(window);
  double took = 0;
  while (!glfwWindowShouldClose(window) && !app.should_quit()) {
    const double rest = app.is_idle() ? 0.25 : std::max(1.0 / 60 - took, in_software && app.is_running() ? took : 1e-3);
    glfwWaitEventsTimeout(listener.keys.has_pending() ? 1e-3 : rest);
    const double start = glfwGetTime();
    const std::vector<Input> inputs = listen(window);
    ImGui_ImplOpenGL3_NewFrame();
    ImGui_ImplGlfw_NewFrame();
    ImGui::NewFrame();
    for (const Input& input : inputs)  // only now does Dear ImGui tell whether a text field uses them
      if ((input.kind == Input::Kind::Key || input.kind == Input::Kind::Modifier) && input.action != GLFW_RELEASE)
        app.key(input.code, input.held);
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
