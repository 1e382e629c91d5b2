// viewer/cli/options/key_options.h: options that each set a key of the scene, and `--set`, which sets any.
// Allowed values, meaning and refusals come from the table of keys (core/scene/scene_fields.h).
#pragma once

#include "core/scene/scene.h"
#include "viewer/cli/options/command.h"

#include <list>
#include <string>
#include <vector>

namespace tessera {

class KeyOptions {
  public:
    /// Adds an option with a word, such as one of the key's names.
    /// @param about  "{names}" and "{default}" are replaced by those of the table
    Option word(Command& command, const std::string& option, const std::string& key,
                const std::string& about);
    /// Adds one with a number.
    Option number(Command& command, const std::string& option, const std::string& key,
                  const std::string& about);
    /// Adds a flag that sets the key to false.
    Option noFlag(Command& command, const std::string& option, const std::string& key,
                  const std::string& about);
    /// Adds `--set KEY=VALUE`, which may be repeated.
    Option set(Command& command);

    /// The value of an option; "" if it was not given.
    std::string textOf(const std::string& option) const;
    /// True if an option or `--set` sets the key, or an object that holds it.
    bool says(const std::string& key) const;
    /// Applies the options. Throws InputError naming the option.
    void apply(Scene& scene) const;
    /// Applies `--set` in the order given. Throws InputError naming it and the key.
    void applySets(Scene& scene) const;

  private:
    struct Row {
        std::string option, key;
        bool isNumber = false;
        std::string text = {}; // as given; "": not given
        bool flag = false;
    };
    std::list<Row> rows_; // a list, because the parser keeps pointers to its items
    std::vector<std::string> sets_;
};

} // namespace tessera
