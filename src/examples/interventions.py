"""The interventions of a bag as a table of pandas, and what the ego did from two seconds before the first.

.venv/bin/python src/examples/interventions.py bags/samples/repaired
"""

import sys

from roadmend import read_bag

bag = read_bag(sys.argv[1])
spells = bag.interventions[["begin", "duration", "dose", "strongest", "because_of", "why"]]
print(spells.to_string())
if len(bag.interventions):
    begin = bag.interventions.begin[0]
    print(bag.ticks.loc[begin - 2.0 : begin, ["speed", "policy_action", "final_action", "status"]])
