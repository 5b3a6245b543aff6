// SPDX-License-Identifier: Apache-2.0
// What a scene amounts to, for people (text) and for programs (JSON, docs/scenes.md lists the
// keys).
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "base/result.h"
#include "sea/certificate/certificate.h"
#include "sea/foam/foam_law.h"
#include "sea/scene/scene.h"
#include "sea/surface/budget/error_budget.h"
#include "sea/waves/statistics/moments.h"

namespace seaway::inspect {

struct Report {
    sea::Scene scene;
    sea::RealizationPtr sea;
    sea::SeaSummary summary;
    sea::ErrorBudget budget;
    sea::FoamLawPtr foam;            ///< null where the scene allows no foam
    sea::CertificatePtr certificate; ///< null where the scene names none
    std::vector<std::string> warnings;
};

/// About 0.2 s for three cascades of 256 x 256.
Result<Report> make_report(const sea::Scene& scene);

/// Every number with a unit in its key; null where a number is infinite (deep water). A flat sea
/// has zeros.
std::string to_json(const Report& report);
std::string to_text(const Report& report);

} // namespace seaway::inspect
