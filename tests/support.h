// SPDX-License-Identifier: Apache-2.0
// What tests of whole runs share: folders that vanish, files by their bytes, and the malha command as a process.
#pragma once
#include <fcntl.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

namespace malha {

inline bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

inline std::string bytes_of(const std::filesystem::path& path) {
  std::ostringstream bytes;
  bytes << std::ifstream(path, std::ios::binary).rdbuf();
  return bytes.str();
}

/// The first of that name that can be run; "" without.
inline std::string program_on_path(const std::string& name) {
  const char* const path = std::getenv("PATH");
  std::istringstream folders(path != nullptr ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');) {
    const std::filesystem::path file = std::filesystem::path(folder) / name;
    if (access(file.c_str(), X_OK) == 0) return file.string();
  }
  return "";
}

/// Every file below the folder by its path from there, with its bytes; empty if there is no such folder.
inline std::map<std::string, std::string> files_in(const std::filesystem::path& folder) {
  std::map<std::string, std::string> files;
  if (!std::filesystem::exists(folder)) return files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) files[entry.path().lexically_relative(folder).string()] = bytes_of(entry.path());
  return files;
}

/// A fresh folder, gone with this object.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "malha_test_XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("cannot make " + name);
    path_ = name;
  }
  ~TemporaryFolder() { std::filesystem::remove_all(path_); }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  /// Writes the file and gives back its path.
  std::string write(const std::string& name, const std::string& bytes) const {
    std::ofstream(path_ / name, std::ios::binary) << bytes;
    return (path_ / name).string();
  }

 private:
  std::filesystem::path path_;
};

struct Ended {
  int status = 0;  // of exit, or -(the signal that killed it)
  std::string out, err;
};

/// The malha command with these arguments, running in `folder`.
class MalhaProcess {
 public:
  /// `most_bytes`: of any file that it writes; beyond that writing fails as on a full disk.
  MalhaProcess(const std::vector<std::string>& arguments, const std::filesystem::path& folder,
               rlim_t most_bytes = RLIM_INFINITY, const std::string& program = MALHA_COMMAND) {
    std::vector<std::string> words{program};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    const std::string at = folder.string(), out = logs_ / "out", err = logs_ / "err";
    child_ = fork();
    if (child_ != 0) return;
    // Only what is safe between fork and exec.
    const int out_file = open(out.c_str(), O_WRONLY | O_CREAT, 0600),
              err_file = open(err.c_str(), O_WRONLY | O_CREAT, 0600);
    const rlimit limit{most_bytes, most_bytes};
    if (chdir(at.c_str()) == 0 && dup2(out_file, STDOUT_FILENO) >= 0 && dup2(err_file, STDERR_FILENO) >= 0 &&
        setrlimit(RLIMIT_FSIZE, &limit) == 0) {
      std::signal(SIGXFSZ, SIG_IGN);
      std::signal(SIGINT, SIG_DFL);  // a job in a shell's background ignores it
      execv(argv[0], argv.data());
    }
    _exit(127);
  }
  ~MalhaProcess() {
    if (child_ <= 0) return;
    kill(child_, SIGKILL);
    waitpid(child_, nullptr, 0);
  }
  MalhaProcess(const MalhaProcess&) = delete;
  MalhaProcess& operator=(const MalhaProcess&) = delete;

  void send(int signal) const { kill(child_, signal); }
  bool running() {
    if (child_ > 0 && waitpid(child_, &state_, WNOHANG) == child_) child_ = 0;
    return child_ > 0;
  }
  /// That it has worked for so far; only while running().
  double cpu_seconds() const {
    clockid_t clock{};
    timespec time{};
    if (clock_getcpuclockid(child_, &clock) != 0 || clock_gettime(clock, &time) != 0) return 0;
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
  }
  Ended wait() {
    if (child_ > 0) waitpid(child_, &state_, 0);
    child_ = 0;
    return {WIFEXITED(state_) ? WEXITSTATUS(state_) : -WTERMSIG(state_), bytes_of(logs_ / "out"),
            bytes_of(logs_ / "err")};
  }

 private:
  TemporaryFolder logs_;
  pid_t child_ = 0;
  int state_ = 0;
};

inline Ended malha_command(const std::vector<std::string>& arguments, const std::filesystem::path& folder) {
  return MalhaProcess(arguments, folder).wait();
}

}  // namespace malha
