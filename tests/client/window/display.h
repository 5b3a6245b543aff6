// SPDX-License-Identifier: Apache-2.0
// A display without a screen: Xvfb on a free number, stopped by its process id; what it shows, and a mouse and keys.
#pragma once

#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/support/folder.h"
#include "tests/support/program.h"
#include "tests/support/read_file.h"

namespace seaway::tests {

/// What is on the screen, or on a part of it.
struct Screenshot {
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgb; ///< [y][x][3], row 0 on top

    const std::uint8_t* pixel(int x, int y) const {
        return &rgb[3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                         static_cast<std::size_t>(x))];
    }
    double luminance(int x, int y) const {
        const std::uint8_t* p = pixel(x, y);
        return 0.2126 * p[0] + 0.7152 * p[1] + 0.0722 * p[2];
    }
    /// Mean over columns left <= x < right of row y.
    double row(int y, int left, int right) const {
        double sum = 0;
        for (int x = left; x < right; ++x)
            sum += luminance(x, y);
        return sum / (right - left);
    }
    double mean() const {
        double sum = 0;
        for (int y = 0; y < height; ++y)
            sum += row(y, 0, width);
        return sum / height;
    }
};

class Display {
  public:
    static constexpr int width = 1400, height = 900;

    /// DISPLAY names it from then on, until it goes. -noreset: else it starts anew, and takes no calls for a moment,
    /// whenever its last window goes.
    Display() {
        int numbers[2];
        if (pipe(numbers) != 0)
            std::abort();
        folder_ = folder().fresh("xvfb");
        std::filesystem::create_directory(folder_);
        const std::string number = std::to_string(numbers[1]);
        const std::string screen = std::to_string(width) + "x" + std::to_string(height) + "x24";
        pid_ = fork();
        if (pid_ == 0) {
            const int nothing = open("/dev/null", O_WRONLY);
            dup2(nothing, STDERR_FILENO);
            close(numbers[0]);
            execlp("Xvfb", "Xvfb", "-displayfd", number.c_str(), "-screen", "0", screen.c_str(),
                   "-fbdir", folder_.c_str(), "-nolisten", "tcp", "-noreset", nullptr);
            _exit(127);
        }
        close(numbers[1]);
        char byte = 0;
        while (read(numbers[0], &byte, 1) == 1 && byte != '\n')
            name_ += byte;
        close(numbers[0]);
        name_ = ":" + name_;
        setenv("DISPLAY", name_.c_str(), 1);
        unsetenv("WAYLAND_DISPLAY");
    }
    ~Display() {
        kill(pid_, SIGTERM);
        waitpid(pid_, nullptr, 0);
        unsetenv("DISPLAY");
    }
    Display(const Display&) = delete;
    Display& operator=(const Display&) = delete;

    bool is_there() const { return name_.size() > 1; }
    const std::string& name() const { return name_; }

    /// xdotool with these arguments; what it prints.
    std::string tool(const std::string& arguments) const {
        return run_command("DISPLAY=" + name_ + " xdotool " + arguments).out;
    }

    /// The upper left part of the screen, where windows without a manager lie. From the frame buffer's file, which is
    /// in the format of xwd.
    Screenshot shot(int columns, int rows) const {
        const std::string bytes = read_file(folder_ + "/Xvfb_screen0");
        const auto word = [&](std::size_t n) { // big-endian
            std::uint32_t value = 0;
            for (std::size_t i = 0; i < 4; ++i)
                value = value << 8 | static_cast<std::uint8_t>(bytes.at(4 * n + i));
            return value;
        };
        const std::size_t line_bytes = word(12);
        const std::size_t first = word(0) + std::size_t{12} * word(19);
        Screenshot shot{columns, rows, {}};
        for (int y = 0; y < rows; ++y)
            for (int x = 0; x < columns; ++x)
                for (const std::size_t c : {2u, 1u, 0u}) // blue first
                    shot.rgb.push_back(static_cast<std::uint8_t>(
                        bytes.at(first + static_cast<std::size_t>(y) * line_bytes +
                                 4 * static_cast<std::size_t>(x) + c)));
        return shot;
    }

  private:
    pid_t pid_ = -1;
    std::string name_, folder_;
};

} // namespace seaway::tests
