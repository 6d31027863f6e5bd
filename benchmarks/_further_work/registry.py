"""All experiments, in the order of the pages. Another one is another file and a line here."""

from _further_work import (
    action_level,
    attribute_weights,
    bodies,
    chains,
    company,
    human_teacher,
    push_avoid,
    roads,
    state_vector,
    variety,
)

EXPERIMENTS = {
    module.EXPERIMENT.name: module.EXPERIMENT
    for module in (
        push_avoid,
        attribute_weights,
        variety,
        state_vector,
        action_level,
        bodies,
        chains,
        human_teacher,
        roads,
        company,
    )
}
