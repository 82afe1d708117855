#include "client/evaluation/gnuplot.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <fstream>
#include <iterator>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace dcloc {
namespace {

namespace fs = std::filesystem;

/// A folder for one run's files, removed with it.
class ScratchFolder {
 public:
  ScratchFolder() {
    std::error_code error;
    std::string pattern = (fs::temp_directory_path(error) / "dcloc_plot_XXXXXX").string();
    if (mkdtemp(pattern.data()) != nullptr) path_ = pattern;
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  ~ScratchFolder() {
    std::error_code error;
    if (!path_.empty()) fs::remove_all(path_, error);
  }
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

std::string ReadText(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

// Runs gnuplot on `script` in `folder`, its messages going to `messages`; the exit status of
// waitpid, or an errno.
absl::StatusOr<int> Spawn(const fs::path& script, const fs::path& messages) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, messages.c_str(),
                                   O_WRONLY | O_CREAT | O_TRUNC, 0600);
  std::string name = "gnuplot";
  std::string argument = script.string();
  std::array<char*, 3> argv = {name.data(), argument.data(), nullptr};
  pid_t pid = 0;
  const int error = posix_spawnp(&pid, "gnuplot", &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error == ENOENT) {
    return absl::NotFoundError("plots need the program gnuplot (Debian package gnuplot-nox)");
  }
  if (error != 0) return absl::ErrnoToStatus(error, "cannot run gnuplot");
  int status = 0;
  while (waitpid(pid, &status, 0) < 0) {
    if (errno != EINTR) return absl::ErrnoToStatus(errno, "cannot wait for gnuplot");
  }
  return status;
}

// Draws into `output` with the given terminal.
absl::Status Render(const Picture& picture, const std::string& terminal, const fs::path& folder,
                    const fs::path& output) {
  if (folder.empty()) return absl::InternalError("cannot make a temporary folder for plots");
  const fs::path script = folder / "plot.gp";
  const fs::path messages = folder / "messages.txt";
  // `output` is a name of ours in our folder: nothing in it needs quoting.
  std::ofstream(script) << "set terminal " << terminal << "\nset output '" << output.string()
                        << "'\n"
                        << picture.commands << "\nunset output\n";
  const auto status = Spawn(script, messages);
  if (!status.ok()) return status.status();
  if (*status != 0 || !fs::exists(output)) {
    return absl::InternalError(absl::StrCat("gnuplot failed: ", ReadText(messages)));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::string> RenderSvg(const Picture& picture) {
  const ScratchFolder scratch;
  const fs::path svg = scratch.path() / "plot.svg";
  const std::string terminal =
      absl::StrFormat("svg size %d,%d dynamic font 'sans-serif,14' background rgb 'white'",
                      picture.width_px, picture.height_px);
  if (absl::Status status = Render(picture, terminal, scratch.path(), svg); !status.ok()) {
    return status;
  }
  return ReadText(svg);
}

absl::Status RenderPng(const Picture& picture, const fs::path& png) {
  const ScratchFolder scratch;
  const fs::path drawn = scratch.path() / "plot.png";
  const std::string terminal = absl::StrFormat("pngcairo size %d,%d font 'sans-serif,11'",
                                               picture.width_px, picture.height_px);
  if (absl::Status status = Render(picture, terminal, scratch.path(), drawn); !status.ok()) {
    return status;
  }
  // Beside its place first, so that the file is whole or the older one.
  const fs::path part = png.string() + ".part";
  std::error_code error;
  fs::copy_file(drawn, part, fs::copy_options::overwrite_existing, error);
  if (!error) fs::rename(part, png, error);
  if (error) {
    std::error_code ignored;
    fs::remove(part, ignored);
    return absl::UnavailableError(
        absl::StrCat(png.string(), ": cannot be written: ", error.message()));
  }
  return absl::OkStatus();
}

}  // namespace dcloc
