// SPDX-License-Identifier: Apache-2.0
#include "tests/output/browser.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <stdexcept>

#include "tests/render/read_png.h"
#include "tests/support.h"

namespace malha {

namespace {

namespace fs = std::filesystem;

constexpr int kPatience = 120'000;  // ms, for one answer: a software renderer on a busy machine

std::string decoded(const std::string& base64) {
  static const std::string letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  unsigned bits = 0;
  int have = 0;
  for (const char letter : base64) {
    const std::size_t value = letters.find(letter);
    if (value == std::string::npos) break;
    bits = bits << 6 | static_cast<unsigned>(value), have += 6;
    if (have >= 8) bytes += static_cast<char>(bits >> (have -= 8) & 0xff);
  }
  return bytes;
}

}  // namespace

std::string Browser::command() { return program_on_path("chromium"); }

Browser::Browser(int width, int height) {
  std::string name = (fs::temp_directory_path() / "malha_browser_XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no folder for the browser");
  profile_ = name;
  int down[2], up[2];
  if (pipe2(down, O_CLOEXEC) != 0 || pipe2(up, O_CLOEXEC) != 0) throw std::runtime_error("no pipes");
  const std::string program = command(), size = std::to_string(width) + "," + std::to_string(height);
  const std::vector<std::string> words{program,
                                       "--headless=new",
                                       "--no-sandbox",
                                       "--remote-debugging-pipe",
                                       "--no-first-run",
                                       "--hide-scrollbars",
                                       "--disable-dev-shm-usage",
                                       "--use-angle=swiftshader",
                                       "--enable-unsafe-swiftshader",
                                       "--touch-events=enabled",
                                       "--window-size=" + size,
                                       "--user-data-dir=" + profile_.string(),
                                       "about:blank"};
  std::vector<char*> argv;
  for (const std::string& word : words) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);
  pid_ = fork();
  if (pid_ == 0) {
    setpgid(0, 0);
    // The descriptors are moved off 3 and 4, which the browser reads and writes.
    const int in = fcntl(down[0], F_DUPFD, 10), out = fcntl(up[1], F_DUPFD, 10), none = ::open("/dev/null", O_RDWR);
    dup2(in, 3), dup2(out, 4), dup2(none, 0), dup2(none, 1), dup2(none, 2);
    unsetenv("LD_PRELOAD");
    execv(argv[0], argv.data());
    _exit(127);
  }
  close(down[0]), close(up[1]);
  to_ = down[1], from_ = up[0];
  const Json target = call("Target.createTarget", {{"url", "about:blank"}});
  session_ = call("Target.attachToTarget", {{"targetId", target["targetId"]}, {"flatten", true}})["sessionId"];
  for (const char* part : {"Page.enable", "Runtime.enable", "Log.enable"}) call(part);
  call("Emulation.setDeviceMetricsOverride",
       {{"width", width}, {"height", height}, {"deviceScaleFactor", 1}, {"mobile", false}});
}

Browser::~Browser() {
  if (to_ >= 0) close(to_);
  if (from_ >= 0) close(from_);
  if (pid_ > 0) kill(-pid_, SIGKILL), waitpid(pid_, nullptr, 0);
  std::error_code ignored;
  for (int tries = 0; tries < 20 && fs::exists(profile_, ignored); ++tries) {
    fs::remove_all(profile_, ignored);
    if (fs::exists(profile_, ignored)) usleep(50'000);
  }
}

Browser::Json Browser::receive() {
  for (;;) {
    if (const std::size_t end = read_.find('\0'); end != std::string::npos) {
      const Json message = Json::parse(read_.substr(0, end));
      read_.erase(0, end + 1);
      return message;
    }
    pollfd ready{from_, POLLIN, 0};
    if (poll(&ready, 1, kPatience) <= 0) throw std::runtime_error("the browser does not answer");
    char bytes[65536];
    const ssize_t got = ::read(from_, bytes, sizeof bytes);
    if (got <= 0) throw std::runtime_error("the browser has ended");
    read_.append(bytes, static_cast<std::size_t>(got));
  }
}

void Browser::note(const Json& event) {
  const std::string method = event.value("method", "");
  if (method == "Runtime.exceptionThrown") complaints_.push_back(event["params"]["exceptionDetails"].dump());
  if (method == "Log.entryAdded" && event["params"]["entry"]["level"] != "info" &&
      event["params"]["entry"]["level"] != "verbose")
    complaints_.push_back(event["params"]["entry"]["text"]);
  if (method == "Runtime.consoleAPICalled" && event["params"]["type"] != "log" && event["params"]["type"] != "info")
    complaints_.push_back(event["params"]["args"].dump());
}

Browser::Json Browser::call(const std::string& method, const Json& params) {
  Json message{{"id", ++last_}, {"method", method}, {"params", params}};
  if (!session_.empty()) message["sessionId"] = session_;
  const std::string text = message.dump() + '\0';
  for (std::size_t at = 0; at < text.size();) {
    const ssize_t put = ::write(to_, text.data() + at, text.size() - at);
    if (put <= 0) throw std::runtime_error("the browser takes nothing");
    at += static_cast<std::size_t>(put);
  }
  for (;;) {
    const Json answer = receive();
    if (answer.value("id", 0) != last_) {
      note(answer);
      continue;
    }
    if (answer.contains("error")) throw std::runtime_error(method + ": " + answer["error"].dump());
    return answer["result"];
  }
}

void Browser::open(const fs::path& file) {
  call("Page.navigate", {{"url", "file://" + fs::absolute(file).string()}});
  for (int tries = 0; tries < kPatience / 50; ++tries, usleep(50'000)) {
    if (evaluate("window.malha ? malha.error || '' : ''") != "")
      throw std::runtime_error("the page says: " + evaluate("malha.error").get<std::string>());
    if (evaluate("!!(window.malha && malha.ready && malha.drawn)")) return;
  }
  throw std::runtime_error("the page shows nothing");
}

Browser::Json Browser::evaluate(const std::string& expression) {
  const Json answer =
      call("Runtime.evaluate", {{"expression", expression}, {"awaitPromise", true}, {"returnByValue", true}});
  if (answer.contains("exceptionDetails")) throw std::runtime_error(answer["exceptionDetails"].dump());
  return answer["result"].value("value", Json());
}

Image Browser::screenshot() {
  // Two frames later everything that was requested is on the screen.
  evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done(0))))");
  const std::string png = decoded(call("Page.captureScreenshot")["data"]);
  return read_png(png);
}

void Browser::press(const std::string& key) {
  Json event{{"type", "keyDown"}, {"key", key}};
  if (key.size() == 1) event["text"] = key;
  call("Input.dispatchKeyEvent", event);
  call("Input.dispatchKeyEvent", {{"type", "keyUp"}, {"key", key}});
}

void Browser::drag(double x, double y, double dx, double dy) {
  const auto mouse = [&](const char* type, double at_x, double at_y, int buttons) {
    call("Input.dispatchMouseEvent",
         {{"type", type}, {"x", at_x}, {"y", at_y}, {"button", "left"}, {"buttons", buttons}, {"clickCount", 1}});
  };
  mouse("mousePressed", x, y, 1);
  for (int k = 1; k <= 4; ++k) mouse("mouseMoved", x + dx * k / 4, y + dy * k / 4, 1);
  mouse("mouseReleased", x + dx, y + dy, 0);
}

void Browser::swipe(double x, double y, double dx, double dy) {
  const auto touch = [&](const char* type, const Json& points) {
    call("Input.dispatchTouchEvent", {{"type", type}, {"touchPoints", points}});
  };
  const auto at = [&](int k) { return Json::array({{{"x", x + dx * k / 4}, {"y", y + dy * k / 4}}}); };
  touch("touchStart", at(0));
  for (int k = 1; k <= 4; ++k) touch("touchMove", at(k));
  touch("touchEnd", Json::array());
}

}  // namespace malha
