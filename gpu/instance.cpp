// SPDX-License-Identifier: Apache-2.0
#include "gpu/instance.h"

#include "gpu/call.h"

namespace seaway::gpu {

namespace {

constexpr const char* validation_layer = "VK_LAYER_KHRONOS_validation";
constexpr std::size_t kept_messages = 16;

// volk's pointers are global and, taken from the loader, the same for every instance: load once, and once more
// for an instance with extensions of a window system, whose functions the others do not have.
std::mutex load_mutex;
bool functions_loaded = false, window_functions_loaded = false;

std::atomic<std::size_t> messages_of_all{0};

Result<void> load_loader() {
    const std::lock_guard lock(load_mutex);
    if (Result<void> loaded = call("vkGetInstanceProcAddr", volkInitialize); !loaded)
        return Error{"no Vulkan loader on this machine (install libvulkan1): " +
                     loaded.error().message};
    return {};
}

void load_functions(VkInstance instance, bool of_a_window) {
    const std::lock_guard lock(load_mutex);
    if (!functions_loaded || (of_a_window && !window_functions_loaded))
        volkLoadInstance(instance);
    functions_loaded = true;
    window_functions_loaded |= of_a_window;
}

VKAPI_ATTR VkBool32 VKAPI_CALL on_message(VkDebugUtilsMessageSeverityFlagBitsEXT,
                                          VkDebugUtilsMessageTypeFlagsEXT,
                                          const VkDebugUtilsMessengerCallbackDataEXT* data,
                                          void* user) {
    static_cast<Instance*>(user)->note(data->pMessage);
    return VK_FALSE;
}

} // namespace

Result<std::unique_ptr<Instance>> Instance::create(bool validation,
                                                   std::span<const std::string> extensions) {
    SEAWAY_TRY(load_loader());
    std::vector<const char*> names;
    for (const std::string& extension : extensions)
        names.push_back(extension.c_str());
    if (validation)
        names.push_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);

    const VkApplicationInfo application{.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO,
                                        .pApplicationName = "seaway",
                                        .apiVersion = VK_API_VERSION_1_3};
    const VkValidationFeatureEnableEXT enables[] = {
        VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT};
    const VkValidationFeaturesEXT features{.sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT,
                                           .enabledValidationFeatureCount = 1,
                                           .pEnabledValidationFeatures = enables};
    const VkInstanceCreateInfo info{.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                                    .pNext = validation ? &features : nullptr,
                                    .pApplicationInfo = &application,
                                    .enabledLayerCount = validation ? 1u : 0u,
                                    .ppEnabledLayerNames = &validation_layer,
                                    .enabledExtensionCount =
                                        static_cast<std::uint32_t>(names.size()),
                                    .ppEnabledExtensionNames = names.data()};
    std::unique_ptr<Instance> made(new Instance);
    SEAWAY_TRY(call("vkCreateInstance", vkCreateInstance, &info, nullptr, &made->instance_));
    load_functions(made->instance_, !extensions.empty());
    if (validation)
        SEAWAY_TRY(made->create_messenger());
    return made;
}

Result<void> Instance::create_messenger() {
    const VkDebugUtilsMessengerCreateInfoEXT info{
        .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
        .messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT |
                           VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
        .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_GENERAL_BIT_EXT |
                       VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT |
                       VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT,
        .pfnUserCallback = on_message,
        .pUserData = this};
    const auto create = reinterpret_cast<PFN_vkCreateDebugUtilsMessengerEXT>(
        vkGetInstanceProcAddr(instance_, "vkCreateDebugUtilsMessengerEXT"));
    return call("vkCreateDebugUtilsMessengerEXT", create, instance_, &info, nullptr, &messenger_);
}

Instance::~Instance() {
    if (messenger_ != VK_NULL_HANDLE)
        reinterpret_cast<PFN_vkDestroyDebugUtilsMessengerEXT>(vkGetInstanceProcAddr(
            instance_, "vkDestroyDebugUtilsMessengerEXT"))(instance_, messenger_, nullptr);
    if (instance_ != VK_NULL_HANDLE)
        vkDestroyInstance(instance_, nullptr);
}

Result<std::vector<VkPhysicalDevice>> Instance::physical_devices() const {
    std::uint32_t count = 0;
    SEAWAY_TRY(
        call("vkEnumeratePhysicalDevices", vkEnumeratePhysicalDevices, instance_, &count, nullptr));
    std::vector<VkPhysicalDevice> devices(count);
    SEAWAY_TRY(call("vkEnumeratePhysicalDevices", vkEnumeratePhysicalDevices, instance_, &count,
                    devices.data()));
    devices.resize(count);
    return devices;
}

void Instance::keep_drivers() {
    static const VkInstance kept = [] {
        const VkInstanceCreateInfo info{.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
        VkInstance instance = VK_NULL_HANDLE;
        // Without it drivers come and go as before.
        return vkCreateInstance(&info, nullptr, &instance) == VK_SUCCESS ? instance
                                                                         : VK_NULL_HANDLE;
    }();
    (void)kept;
}

std::size_t Instance::all_validation_messages() {
    return messages_of_all;
}

std::vector<std::string> Instance::validation_messages() const {
    const std::lock_guard lock(mutex_);
    return messages_;
}

void Instance::note(const char* message) {
    ++message_count_;
    ++messages_of_all;
    const std::lock_guard lock(mutex_);
    if (messages_.size() < kept_messages)
        messages_.emplace_back(message);
}

} // namespace seaway::gpu
