// viewer/cli/options/key_options.h: options that set a key of the scene each, and `--set`, which sets any.
// What may be said, what it means and how it is refused is the table's (core/scene/scene_fields.h).
#pragma once

#include "core/scene/scene.h"
#include "viewer/cli/options/command.h"

#include <list>
#include <string>
#include <vector>

namespace tessera {

class KeyOptions {
  public:
    /// An option with a word, such as one of the key's names.
    /// @param about  "{names}" and "{default}" stand for what the table says of the key
    Option word(Command& command, const std::string& option, const std::string& key,
                const std::string& about);
    /// One with a number.
    Option number(Command& command, const std::string& option, const std::string& key,
                  const std::string& about);
    /// A flag that sets the key to false.
    Option noFlag(Command& command, const std::string& option, const std::string& key,
                  const std::string& about);
    /// `--set KEY=VALUE`, as often as one likes.
    Option set(Command& command);

    /// What an option was given; "" where it was not.
    std::string textOf(const std::string& option) const;
    /// Whether an option or `--set` says something of the key, or of what holds it.
    bool says(const std::string& key) const;
    /// Sets what the options name. Throws InputError naming the option.
    void apply(Scene& scene) const;
    /// Sets what `--set` names, in the order that it was given. Throws InputError naming it and the key.
    void applySets(Scene& scene) const;

  private:
    struct Row {
        std::string option, key;
        bool isNumber = false;
        std::string text = {}; // as it was said; "": it was not
        bool flag = false;
    };
    std::list<Row> rows_; // parsers hold on to their places
    std::vector<std::string> sets_;
};

} // namespace tessera
