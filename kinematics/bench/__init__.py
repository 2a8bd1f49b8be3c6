"""Speed and success rate of the arm beside those of installed peers: same queries, same run."""
