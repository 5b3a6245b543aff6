// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/accuracy/journal.h"

#include <filesystem>
#include <fstream>
#include <sstream>
#include <thread>
#include <vector>

#include <fmt/format.h>

#include "base/text_file.h"
#include "gpu/device_info.h"
#include "server/device/device_choice.h"
#include "tools/commit.h"

namespace seaway::bench {

namespace {

constexpr const char* journal_header =
    "state,knob,value,metric,figure,ci_low,ci_high,device,driver,machine,commit";
constexpr std::size_t columns = 11;

/// Only names hold commas or quotes: of devices and machines.
std::string in_quotes(const std::string& text) {
    if (text.find_first_of(",\"") == std::string::npos)
        return text;
    std::string result = "\"";
    for (const char c : text)
        result += c == '"' ? std::string("\"\"") : std::string(1, c);
    return result + "\"";
}

std::vector<std::string> split(const std::string& line) {
    std::vector<std::string> fields(1);
    bool inside = false;
    for (std::size_t i = 0; i < line.size(); ++i) {
        if (line[i] == '"' && inside && i + 1 < line.size() && line[i + 1] == '"')
            fields.back() += line[i++];
        else if (line[i] == '"')
            inside = !inside;
        else if (line[i] == ',' && !inside)
            fields.emplace_back();
        else
            fields.back() += line[i];
    }
    return fields;
}

struct Kept {
    std::vector<std::string> lines; ///< of trials that were finished
    std::set<std::string> done;
};

} // namespace

std::string machine_name() {
    std::ifstream file("/proc/cpuinfo");
    const std::string label = "model name";
    for (std::string line; std::getline(file, line);)
        if (line.compare(0, label.size(), label) == 0) {
            const std::size_t colon = line.find(": ");
            if (colon != std::string::npos)
                return fmt::format("{}, {} cores", line.substr(colon + 2),
                                   std::thread::hardware_concurrency());
        }
    return fmt::format("unknown, {} cores", std::thread::hardware_concurrency());
}

std::string commit_name() {
    return SEAWAY_COMMIT;
}

Result<Place> place_of(const Configuration& configuration, Devices& devices) {
    static const std::string machine = machine_name(), commit = commit_name();
    SEAWAY_TRY_LET(const server::DeviceChoice choice, server::choose_device(configuration.device));
    SEAWAY_TRY_LET(const server::Synthesizer* device, devices.get(configuration));
    std::string driver = "Seaway " SEAWAY_VERSION;
    if (choice.vulkan)
        if (const auto list = gpu::list_devices())
            driver = (*list)[static_cast<std::size_t>(*choice.vulkan)].driver;
    std::string description = device->description();
    if (configuration.any_device_kernels)
        description += ", kernels for any device";
    return Place{std::move(description), std::move(driver), machine, commit};
}

std::string Journal::key(const TrialName& trial) {
    return trial.state + '\n' + trial.knob + '\n' + trial.value + '\n' + trial.device;
}

namespace {

Result<Kept> read_kept(const std::string& path, const std::string& settings) {
    Kept kept;
    if (std::error_code none; !std::filesystem::exists(std::filesystem::symlink_status(path, none)))
        return kept;
    if (const Result<void> regular = check_regular_file(path); !regular)
        return Error{fmt::format("{} {}", path, regular.error().message)};
    std::ifstream file(path);
    if (!file)
        return Error{fmt::format("{} cannot be read, and holds what an earlier run found", path)};
    std::string line;
    if (!std::getline(file, line))
        return kept;
    if (line != "# " + settings)
        return Error{
            fmt::format("{} is of another run ({}); this one is \"{}\": remove the file or "
                        "give another --out",
                        path, line, settings)};
    std::getline(file, line); // the journal_header
    std::vector<std::string> trial;
    std::string current;
    while (std::getline(file, line)) {
        const std::vector<std::string> fields = split(line);
        if (fields.size() != columns)
            continue; // cut off when the run was stopped
        const std::string name = fields[0] + '\n' + fields[1] + '\n' + fields[2] + '\n' + fields[7];
        if (name != current)
            trial.clear();
        current = name;
        trial.push_back(line);
        if (fields[3] != "done")
            continue;
        kept.lines.insert(kept.lines.end(), trial.begin(), trial.end());
        kept.done.insert(name);
        trial.clear();
    }
    return kept;
}

} // namespace

Result<Journal> Journal::open(const std::string& path, const std::string& settings) {
    SEAWAY_TRY_LET(Kept kept, read_kept(path, settings));
    Journal journal;
    journal.path_ = path;
    journal.done_ = std::move(kept.done);
    {
        std::ofstream whole(path + ".part");
        whole << "# " << settings << '\n' << journal_header << '\n';
        for (const std::string& line : kept.lines)
            whole << line << '\n';
        if (!whole.flush())
            return Error{"cannot write " + path + ".part"};
    }
    std::error_code failed;
    std::filesystem::rename(path + ".part", path, failed);
    journal.file_.open(path, std::ios::app);
    if (failed || !journal.file_)
        return Error{"cannot write " + path};
    return journal;
}

Result<void> Journal::add(const TrialName& trial, const Place& place,
                          std::span<const Figure> figures, double seconds) {
    std::ostringstream rows;
    const auto row = [&](const Figure& f) {
        rows << fmt::format("{},{},{},{},{:.6g},{:.6g},{:.6g},{},{},{},{}\n", trial.state,
                            trial.knob, in_quotes(trial.value), f.metric, f.value, f.low, f.high,
                            in_quotes(trial.device), in_quotes(place.driver),
                            in_quotes(place.machine), place.commit);
    };
    for (const Figure& figure : figures)
        row(figure);
    row(exact("done", seconds));
    file_ << rows.str();
    if (!file_.flush())
        return Error{"cannot write " + path_};
    done_.insert(key(trial));
    return {};
}

} // namespace seaway::bench
