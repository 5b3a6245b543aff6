// SPDX-License-Identifier: Apache-2.0
#include "base/text_file.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <iostream>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/messages.h"

namespace seaway {

namespace {

Error because_of(int number) {
    if (number == ENOENT || number == ENOTDIR)
        return {"no such file"};
    return {fmt::format("not readable: {}", std::strerror(number))};
}

Result<void> check_kind(const struct stat& status) {
    if (S_ISDIR(status.st_mode))
        return Error{"is a folder; a regular file is needed"};
    if (!S_ISREG(status.st_mode))
        return Error{"is a pipe, a device or a socket; a regular file is needed"};
    return {};
}

class Descriptor {
  public:
    explicit Descriptor(int number) : number_(number) {}
    ~Descriptor() {
        if (number_ >= 0)
            ::close(number_);
    }
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    int number() const { return number_; }

  private:
    int number_;
};

} // namespace

Result<std::string> read_text_file(const std::string& path, std::size_t bytes_max) {
    // Without O_NONBLOCK, opening a pipe waits for somebody who writes to it.
    const Descriptor file(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
    struct stat status {};
    if (file.number() < 0 || ::fstat(file.number(), &status) != 0)
        return because_of(errno);
    SEAWAY_TRY(check_kind(status));
    constexpr std::size_t piece = 64 * 1024;
    std::string text;
    while (text.size() <= bytes_max) {
        const std::size_t held = text.size();
        text.resize(held + piece);
        const ssize_t got = ::read(file.number(), text.data() + held, piece);
        text.resize(held + (got > 0 ? static_cast<std::size_t>(got) : 0));
        if (got < 0 && errno != EINTR)
            return because_of(errno);
        if (got == 0)
            return text;
    }
    return Error{fmt::format("has more than {} bytes", bytes_max)};
}

Result<void> check_regular_file(const std::string& path) {
    struct stat status {};
    if (::stat(path.c_str(), &status) != 0)
        return because_of(errno);
    SEAWAY_TRY(check_kind(status));
    if (::access(path.c_str(), R_OK) != 0)
        return because_of(errno);
    return {};
}

Result<void> check_replaceable(const std::string& path) {
    struct stat status {};
    return ::stat(path.c_str(), &status) == 0 ? check_kind(status) : Result<void>();
}

Result<void> write_out(std::FILE* out, std::string_view text) {
    // fwrite() may not be given the null that an empty view holds.
    const bool written =
        text.empty() || std::fwrite(text.data(), 1, text.size(), out) == text.size();
    if (std::fflush(out) != 0 || !written || std::ferror(out) != 0)
        return Error{OutputError::lost,
                     "cannot write to standard output: what was printed is lost"};
    return {};
}

Result<void> finish_standard_output() {
    std::cout.flush();
    SEAWAY_TRY(write_out(stdout, {}));
    if (!std::cout)
        return Error{OutputError::lost,
                     "cannot write to standard output: what was printed is lost"};
    return {};
}

int status_after_output(const char* program, int status, int lost_status) {
    const Result<void> finished = finish_standard_output();
    if (status != 0 || finished)
        return status;
    return complain(program, lost_status, finished.error().message);
}

} // namespace seaway
