#pragma once

#include "apps/measured_transfer.hpp"
#include "ident/bootstrap.hpp"
#include "ident/doubts.hpp"

namespace struna::apps {

/// So many replicates of a study's records (ident/wild_records.hpp, seed 1), each brought to its modes as the
/// study's own were: how these scatter, against what their fit states. `nominal`: the study's modes;
/// `estimates`: how each reference's functions were estimated, over all lines and in the form measured.
/// Throws Error for records of more than 2^26 numbers.
ident::BootstrapScatter bootstrap(const Study& study, const std::vector<ident::TransferEstimate>& estimates,
                                  const ident::ModeSet& nominal, long replicates);

/// nullopt where no mode scatters otherwise than stated.
std::optional<ident::Doubt> scatter_doubt(const ident::BootstrapScatter& scatter);

/// "bootstrap: ..." in a line.
std::string bootstrap_line(const ident::BootstrapScatter& scatter);

/// The corrections of the columns that this reference reads.
std::map<std::string, ident::ChannelCorrection> corrections_of(const Study& study,
                                                               const StudyReference& reference);

}  // namespace struna::apps
