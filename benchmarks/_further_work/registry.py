"""All experiments, in the order of the pages. Another one is another file and a line here."""

from _further_work import bodies, chains, company, push_avoid, roads, variety

EXPERIMENTS = {
    module.EXPERIMENT.name: module.EXPERIMENT
    for module in (push_avoid, variety, bodies, chains, roads, company)
}
